// Curves as SVG for reports, drawn by the program gnuplot when this machine has it.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace turgor {

struct Curve {
  std::string label;
  std::vector<std::pair<double, double>> points;
};
struct Plot {
  std::string title, x_label, y_label;  // labels with units
  std::vector<Curve> curves;
  bool logarithmic = false;  // the y axis
};

/// An <svg> element that suits light and dark pages; empty without gnuplot or without points. `folder` takes
/// two temporary files.
std::string plot_svg(const Plot& plot, const std::filesystem::path& folder);

}  // namespace turgor
