// Curves as SVG with axes, grid and legend, for reports and documents.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace turgor {

struct Curve {
  std::string label;
  std::vector<std::pair<double, double>>
      points;  // points that are not finite, or not positive on a logarithmic axis, are omitted
};
/// Marked interval of the x axis, behind the curves.
struct Band {
  std::string label;
  double from = 0, to = 0;
};
/// Shaded region between two curves over the same x, behind all curves.
struct ShadedRegion {
  std::string label;
  struct Point {
    double x, low, high;
  };
  std::vector<Point> points;
};
struct Plot {
  std::string title, x_label, y_label;  // labels with units
  std::vector<Curve> curves;
  bool logarithmic = false;  // the y axis
  std::vector<Band> bands = {};
  ShadedRegion region = {};  // on linear axes; without points none
};

/// An <svg> element for light and dark pages; empty without points. Labels are escaped.
std::string plot_svg(const Plot& plot);
/// The same as a standalone file.
std::string plot_svg_file(const Plot& plot);

}  // namespace turgor
