#include "turgor/sim/scene/label_number.hpp"

#include <charconv>
#include <vector>

#include "turgor/io/organ_names.hpp"
#include "turgor/sim/scene/nearest_name.hpp"

namespace turgor {

namespace {

constexpr int kMostNamed = 255;  // no label above has a name

}  // namespace

int label_number(const std::string& name) {
  for (int label = 1; label <= kMostNamed; label++)
    if (organ_name(label) == name) return label;
  int label = 0;
  const char* end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data(), end, label);
  return error == std::errc() && stop == end && label > 0 && label <= 65535 ? label : -1;
}

std::string label_suggestion(const std::string& name) {
  std::vector<std::string> organs;
  for (int label = 1; label <= kMostNamed; label++)
    if (std::string organ = organ_name(label); !organ.empty()) organs.push_back(std::move(organ));
  const std::string nearest = nearest_name(name, organs);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace turgor
