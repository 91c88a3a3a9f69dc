#include "turgor/sim/report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/round_ticks.hpp"
#include "turgor/io/files/xml_text.hpp"

namespace turgor {

namespace {

using Points = std::vector<std::pair<double, double>>;

/// Color-blind safe palette (Okabe and Ito) for light and dark backgrounds.
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

// size of the picture; reports scale it down to at least 460 pixels, and text to at least 11 pixels
constexpr double kWidth = 560, kCurves = 210, kFont = 14, kLine = 20;  // kCurves: height of the curves
constexpr double kLeft = 76, kRight = 24, kBottom = 48;
constexpr std::size_t kLongestLabel = 48;  // letters

struct Range {
  double low = std::numeric_limits<double>::max(), high = -std::numeric_limits<double>::max();
  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
};

/// Mapping from numbers to pixels.
struct Axes {
  Range x, y;  // y of a logarithmic axis as powers of ten
  double top = 0;
  bool logarithmic = false;
  double bottom() const { return top + kCurves; }
  double px(double value) const {
    TURGOR_CHECK(x.high > x.low, "an axis has a length");
    return kLeft + (kWidth - kLeft - kRight) * (value - x.low) / (x.high - x.low);
  }
  double py(double value) const { return bottom() - kCurves * (value - y.low) / (y.high - y.low); }
};

Points drawable(const Points& points, bool logarithmic) {
  constexpr double kMost = 1e300,
                   kLeast = 1e-290;  // larger or smaller numbers overflow or vanish in differences
  const auto plain = [](double value) { return std::abs(value) < kLeast ? 0 : value; };
  Points kept;
  for (const auto& [x, y] : points)
    if (std::abs(x) < kMost && std::abs(y) < kMost && (!logarithmic || y > 0))
      kept.emplace_back(plain(x), logarithmic ? std::log10(y) : plain(y));
  return kept;
}

/// Reduces the points to the minimum and the maximum per pixel column.
Points thinned(const Points& points) {
  // short curves keep all points
  constexpr std::size_t kStretches = 600;
  if (points.size() <= 2 * kStretches) return points;
  // minimum and maximum of each interval, in order of time
  Points kept{points.front()};
  for (std::size_t s = 0; s < kStretches; s++) {
    const auto begin = points.begin() + std::ptrdiff_t(s * points.size() / kStretches);
    const auto end = points.begin() + std::ptrdiff_t((s + 1) * points.size() / kStretches);
    auto [low, high] =
        std::minmax_element(begin, end, [](const auto& a, const auto& b) { return a.second < b.second; });
    if (high < low) std::swap(low, high);
    kept.push_back(*low);
    if (low != high) kept.push_back(*high);
  }
  kept.push_back(points.back());
  return kept;
}

/// Range with a positive width.
void widen(Range& range) {
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  if (range.high - range.low > 1e-9 * size) return;
  const double margin = size > 0 ? 0.05 * size : 1;
  range = {range.low - margin, range.high + margin};
}

Axes make_axes(const std::vector<Points>& curves, bool logarithmic, double top) {
  Axes axes{.top = top, .logarithmic = logarithmic};
  for (const Points& points : curves)
    for (const auto& [x, y] : points) axes.x.add(x), axes.y.add(y);
  widen(axes.x);
  if (logarithmic) {
    axes.y = {std::floor(axes.y.low), std::max(std::ceil(axes.y.high), std::floor(axes.y.low) + 1)};
    return axes;
  }
  axes.y.add(0);
  widen(axes.y);
  const std::vector<double> ticks = round_ticks(axes.y.low, axes.y.high, 5);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 0;  // extends to the next round number
  TURGOR_CHECK(!ticks.empty(), "an axis has ticks");
  if (ticks.back() < axes.y.high) axes.y.high = ticks.back() + step;
  if (ticks.front() > axes.y.low) axes.y.low = ticks.front() - step;
  return axes;
}

std::string power_of_ten(int exponent) {
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : fmt::format("{}", std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

/// Number of digits that distinguishes adjacent ticks.
std::string tick_text(double value, const std::vector<double>& ticks) {
  TURGOR_CHECK(!ticks.empty(), "an axis has ticks");
  const double most = std::max(std::abs(ticks.front()), std::abs(ticks.back()));
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : most;
  if (std::abs(value) < 0.5 * step) return "0";
  if (most >= 1e5 || step < 1e-4) return fmt::format("{:.4g}", value);
  return fmt::format("{:.{}f}", value, std::max(0, -int(std::floor(std::log10(step) + 1e-9))));
}

std::string text_at(double x, double y, const char* attributes, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, attributes, xml_text(text));
}

std::string grid_line(double x1, double y1, double x2, double y2) {
  return fmt::format("<path class=\"plot-grid\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", x1, y1, x2, y2);
}

std::string draw_axes(const Axes& axes, const Plot& plot) {
  const double bottom = axes.bottom(), right = kWidth - kRight;
  std::string svg;
  // vertical grid lines and ticks
  const std::vector<double> columns = round_ticks(axes.x.low, axes.x.high, 6);
  for (const double x : columns)
    svg += grid_line(axes.px(x), axes.top, axes.px(x), bottom) +
           text_at(axes.px(x), bottom + 17, "text-anchor=\"middle\"", tick_text(x, columns));
  // horizontal grid lines and ticks; a log axis keeps whole powers of ten
  std::vector<double> rows = round_ticks(axes.y.low, axes.y.high, 5);
  if (axes.logarithmic) std::erase_if(rows, [](double y) { return std::abs(y - std::round(y)) > 0.01; });
  for (const double y : rows)
    svg += grid_line(kLeft, axes.py(y), right, axes.py(y)) +
           text_at(kLeft - 8, axes.py(y) + 5, "text-anchor=\"end\"",
                   axes.logarithmic ? power_of_ten(int(std::lround(y))) : tick_text(y, rows));
  // axis lines and labels
  const double middle = 0.5 * (axes.top + bottom);
  svg += fmt::format("<path class=\"plot-axis\" d=\"M{0:.1f} {1:.1f}V{2:.1f}H{3:.1f}\"/>\n", kLeft, axes.top,
                     bottom, right);
  svg += text_at(0.5 * (kLeft + right), bottom + kBottom - 8, "text-anchor=\"middle\"", plot.x_label);
  const std::string turned =
      fmt::format("text-anchor=\"middle\" transform=\"rotate(-90 16 {:.1f})\"", middle);
  return svg + text_at(16, middle, turned.c_str(), plot.y_label);
}

/// Plot area with its number range; the page's script reads it to show the values under the mouse.
std::string draw_area(const Axes& axes) {
  return fmt::format(
      "<rect class=\"plot-area\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
      "fill=\"none\" data-x=\"{:.9g} {:.9g}\" data-y=\"{:.9g} {:.9g}\" data-powers=\"{}\"/>\n",
      kLeft, axes.top, kWidth - kLeft - kRight, kCurves, axes.x.low, axes.x.high, axes.y.low, axes.y.high,
      axes.logarithmic ? "yes" : "no");
}

/// Truncates at a character boundary.
std::string short_label(const std::string& label) {
  std::size_t letters = 0;
  for (std::size_t i = 0; i < label.size(); i++)
    if ((label[i] & 0xc0) != 0x80 && letters++ == kLongestLabel) return label.substr(0, i) + "…";
  return label;
}

/// Clips the interval to the axis; its name is drawn once, at the top.
std::string draw_bands(const Axes& axes, const std::vector<Band>& bands) {
  std::string svg, named;
  for (const Band& band : bands) {
    // clip the band to the x range
    const double from = std::max(band.from, axes.x.low), to = std::min(band.to, axes.x.high);
    if (!(from < to)) continue;
    svg += fmt::format(
        "<rect class=\"plot-band\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
        axes.px(from), axes.top, axes.px(to) - axes.px(from), kCurves);
    // a run of equal labels is written once
    if (band.label != named)
      svg += text_at(axes.px(0.5 * (from + to)), axes.top + kLine - 4, "text-anchor=\"middle\"",
                     short_label(band.label));
    named = band.label;
  }
  return svg;
}

/// Points of a region that can be drawn on a linear axis: its lower and its upper border.
struct RegionBorders {
  Points low, high;
};
RegionBorders region_borders(const Plot& plot) {
  RegionBorders borders;
  if (plot.logarithmic) return borders;
  for (const ShadedRegion::Point& point : plot.region.points) {
    borders.low.emplace_back(point.x, point.low), borders.high.emplace_back(point.x, point.high);
    if (drawable({borders.low.back(), borders.high.back()}, false).size() == 2) continue;
    borders.low.pop_back(), borders.high.pop_back();
  }
  return borders;
}

/// Along the lower border and back along the upper one.
std::string draw_region(const Axes& axes, const RegionBorders& borders) {
  std::string path;
  const auto add = [&](const auto& point) {
    path +=
        fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", axes.px(point.first), axes.py(point.second));
  };
  std::for_each(borders.low.begin(), borders.low.end(), add);
  std::for_each(borders.high.rbegin(), borders.high.rend(), add);
  return path.empty() ? "" : fmt::format("<path class=\"plot-band\" d=\"{}Z\"/>\n", path);
}

std::string draw_curve(const Axes& axes, const Points& points, const std::string& label, const char* color) {
  constexpr std::size_t kMostDots = 40;
  // path through the thinned points, with dots on short curves
  std::string path, dots;
  for (const auto& [x, y] : thinned(points)) {
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", axes.px(x), axes.py(y));
    if (points.size() <= kMostDots)
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>\n", axes.px(x),
                          axes.py(y), color);
  }
  // curve element
  return fmt::format(
             "<path class=\"plot-curve\" data-label=\"{}\" d=\"{}\" fill=\"none\" stroke=\"{}\" "
             "stroke-width=\"2\" "
             "stroke-linejoin=\"round\"/>\n",
             xml_text(label), path, color) +
         dots;
}

struct Legend {
  std::string svg;
  double bottom;  // [pixels]
};
Legend draw_legend(const Plot& plot, const std::vector<Points>& points, bool has_region, double top) {
  // layout in pixels; the letter width is an estimate
  constexpr double kLetter = 0.58 * kFont, kSwatch = 30, kGap = 18;
  Legend legend{"", top};
  double x = kLeft;
  // swatch(x, y): left end and middle of an entry's mark
  const auto add = [&](const std::string& text, const auto& swatch) {
    // width of the entry; UTF-8 continuation bytes do not count as letters
    const std::string label = short_label(text);
    const auto letters = std::count_if(label.begin(), label.end(), [](char l) { return (l & 0xc0) != 0x80; });
    const double width = kSwatch + kLetter * double(letters);
    // wrap to the next line
    if (x > kLeft && x + width > kWidth - kRight) x = kLeft, legend.bottom += kLine;
    legend.svg +=
        swatch(x, legend.bottom + kLine - 9) + text_at(x + kSwatch, legend.bottom + kLine - 4, "", label);
    x += width + kGap;
  };
  TURGOR_CHECK(plot.curves.size() == points.size(), "every curve has points");
  for (std::size_t c = 0; c < plot.curves.size(); c++) {
    if (points[c].empty()) continue;
    add(plot.curves[c].label, [&](double left, double middle) {
      return fmt::format("<path d=\"M{:.1f} {:.1f}h22\" stroke=\"{}\" stroke-width=\"3\"/>\n", left, middle,
                         kColors[c % std::size(kColors)]);
    });
  }
  if (has_region)
    add(plot.region.label, [](double left, double middle) {
      return fmt::format("<path class=\"plot-band\" d=\"M{:.1f} {:.1f}h22v12h-22Z\"/>\n", left, middle - 6);
    });
  legend.bottom += kLine;
  return legend;
}

constexpr const char* kPlotHead =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
    "height=\"{1:.0f}\" role=\"img\" class=\"turgor-plot\" font-family=\"system-ui, 'DejaVu Sans', "
    "sans-serif\" "
    "font-size=\"{2:.0f}\">\n<title>{3}</title>\n<style>"
    ".turgor-plot text {{ fill: #43494f; }} .plot-grid {{ stroke: #9aa1a8; stroke-width: 0.5; opacity: 0.5; "
    "}} "
    ".plot-band {{ fill: #e69f00; opacity: 0.22; }} "
    ".plot-axis {{ stroke: #767d85; fill: none; }} @media (prefers-color-scheme: dark) {{ "
    ".turgor-plot text {{ fill: #b9c0c7; }} }}</style>\n";

}  // namespace

std::string plot_svg(const Plot& plot) {
  // drawable points; without any, the plot is empty
  std::vector<Points> curves;
  for (const Curve& curve : plot.curves) curves.push_back(drawable(curve.points, plot.logarithmic));
  if (std::all_of(curves.begin(), curves.end(), [](const Points& points) { return points.empty(); }))
    return "";
  // layout: legend above the axes, which hold the curves and the region
  const RegionBorders borders = region_borders(plot);
  const Legend legend = draw_legend(plot, curves, !borders.low.empty(), 1.5 * kLine);
  std::vector<Points> all = curves;
  all.push_back(borders.low), all.push_back(borders.high);
  const Axes axes = make_axes(all, plot.logarithmic, legend.bottom + 0.5 * kLine);
  // frame: title, legend, bands, region, axes
  std::string svg = fmt::format(kPlotHead, kWidth, axes.bottom() + kBottom, kFont, xml_text(plot.title)) +
                    text_at(kLeft, kLine, "font-weight=\"600\"", plot.title) + legend.svg +
                    draw_bands(axes, plot.bands) + draw_region(axes, borders) + draw_axes(axes, plot) +
                    draw_area(axes);
  // curves
  for (std::size_t c = 0; c < curves.size(); c++)
    if (!curves[c].empty())
      svg += draw_curve(axes, curves[c], plot.curves[c].label, kColors[c % std::size(kColors)]);
  return svg + "</svg>\n";
}

std::string plot_svg_file(const Plot& plot) {
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n" + plot_svg(plot);
}

}  // namespace turgor
