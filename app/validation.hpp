// A figure of docs/validation.md: result of a model, its reference, and the bound that it must keep.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/exec.hpp"

namespace turgor {

/// A result that must lie between `low` and `high`.
struct Figure {
  std::string name;
  std::string against;  // reference formula or program
  std::string unit;
  double found = 0, low = 0, high = 0;
  // Known failure, listed in docs/validation.md: printed as missed, but the run does not fail.
  bool known_limit = false;
};

inline bool is_missed(const Figure& f) { return !(f.found >= f.low && f.found <= f.high); }

/// The larger of both; infinity if `found` is not finite, so that its figure is missed.
inline double widest(double worst, double found) {
  return std::isfinite(found) ? std::max(worst, found) : std::numeric_limits<double>::infinity();
}
/// The smaller of both; minus infinity if `found` is not finite.
inline double narrowest(double least, double found) { return -widest(-least, -found); }

/// Figure with |found/expected − 1| ≤ `bound`.
Figure near_figure(const std::string& name, const std::string& against, double found, double expected,
                   double bound);
/// Figure that is finite and at most `most`.
Figure most_figure(const std::string& name, const std::string& against, const std::string& unit, double found,
                   double most);

/// Prints a table on standard output.
void print_figures(const std::vector<Figure>& figures);
nlohmann::ordered_json to_json(const std::vector<Figure>& figures);
/// Names of missed figures that are not known limits.
std::vector<std::string> missed_names(const std::vector<Figure>& figures);

/// `quick`: less than two minutes of one core and 1 GB each.
std::vector<Figure> validate_rhombus(const Exec& exec, bool quick);
std::vector<Figure> validate_cloth(const Exec& exec, bool quick);
std::vector<Figure> validate_lattice(const Exec& exec, bool quick);

}  // namespace turgor
