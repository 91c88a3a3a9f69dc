#include "app/validation.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/print.hpp"

namespace turgor {

Figure near_figure(const std::string& name, const std::string& against, double found, double expected,
                   double bound) {
  return {name, against, "times the expected", found / expected, 1 - bound, 1 + bound};
}

Figure most_figure(const std::string& name, const std::string& against, const std::string& unit, double found,
                   double most) {
  return {name, against, unit, found, -std::numeric_limits<double>::max(), most};
}

void print_figures(const std::vector<Figure>& figures) {
  for (const Figure& f : figures) {
    const std::string bound = f.low < -1e300 ? fmt::format("at most {:.7g}", f.high)
                                             : fmt::format("{:.7g} to {:.7g}", f.low, f.high);
    const char* verdict = !is_missed(f) ? "kept" : f.known_limit ? "missed (known limit)" : "MISSED";
    print_plain("  {:<68} {:>11.7g} {} ({}; {}): {}\n", f.name, f.found, f.unit, bound, f.against, verdict);
  }
}

nlohmann::ordered_json to_json(const std::vector<Figure>& figures) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Figure& f : figures) {
    nlohmann::ordered_json one{
        {"name", f.name}, {"against", f.against}, {"unit", f.unit}, {"found", f.found}, {"most", f.high}};
    if (f.low > -1e300) one["least"] = f.low;
    one["missed"] = is_missed(f);
    if (f.known_limit) one["known_limit"] = true;
    json.push_back(std::move(one));
  }
  return json;
}

std::vector<std::string> missed_names(const std::vector<Figure>& figures) {
  std::vector<std::string> names;
  for (const Figure& f : figures)
    if (is_missed(f) && !f.known_limit) names.push_back(f.name);
  return names;
}

}  // namespace turgor
