// A figure of docs/validation.md: what a model answers, what it is held against, and the bound that it keeps.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/exec.hpp"

namespace turgor {

/// What was found lies between `low` and `high`.
struct Figure {
  std::string name;
  std::string against;  // the formula or program that knows better
  std::string unit;
  double found = 0, low = 0, high = 0;
  // What the model is known not to do, in docs/validation.md: printed as missed, and no reason to fail.
  bool known_limit = false;
};

inline bool is_missed(const Figure& f) { return !(f.found >= f.low && f.found <= f.high); }

/// found/expected − 1 is at most `bound`, either way.
Figure near_figure(const std::string& name, const std::string& against, double found, double expected,
                   double bound);
/// No more than `most`, and finite.
Figure most_figure(const std::string& name, const std::string& against, const std::string& unit, double found,
                   double most);

/// As a table on standard output.
void print_figures(const std::vector<Figure>& figures);
nlohmann::ordered_json to_json(const std::vector<Figure>& figures);
/// Names of those that are missed without being known limits.
std::vector<std::string> missed_names(const std::vector<Figure>& figures);

/// `quick`: less than two minutes of one core and 1 GB each.
std::vector<Figure> validate_rhombus(const Exec& exec, bool quick);
std::vector<Figure> validate_cloth(const Exec& exec, bool quick);
std::vector<Figure> validate_lattice(const Exec& exec, bool quick);

}  // namespace turgor
