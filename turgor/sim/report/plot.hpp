// Curves as SVG, for reports and documents: axes with round numbers, a grid, a legend above the curves.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace turgor {

struct Curve {
  std::string label;
  std::vector<std::pair<double, double>>
      points;  // what is not finite, or not positive on a logarithmic axis, is left out
};
/// A part of the x axis that is marked, behind the curves.
struct Band {
  std::string label;
  double from = 0, to = 0;
};
struct Plot {
  std::string title, x_label, y_label;  // labels with units
  std::vector<Curve> curves;
  bool logarithmic = false;  // the y axis
  std::vector<Band> bands = {};
};

/// An <svg> element that suits light and dark pages; empty without points. Whatever the labels hold is text.
std::string plot_svg(const Plot& plot);
/// The same as a file of its own.
std::string plot_svg_file(const Plot& plot);

}  // namespace turgor
