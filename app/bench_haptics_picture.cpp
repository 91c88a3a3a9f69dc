// Z-width as an SVG picture: one rectangle per wall, colored by the speed of the hand at the end of the
// trial.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/bench_haptics.hpp"
#include "turgor/io/files/xml_text.hpp"

namespace turgor {

namespace {

// [pixels]; distances between panels are multiples of the dot pattern
constexpr double kCellWide = 10, kCellHigh = 13, kLeft = 64, kGap = 40, kTop = 78, kPanelGap = 65, kFont = 13;

struct Panel {
  double x, y;  // upper left corner [pixels]
};

std::string text(double x, double y, const char* anchor, const std::string& words) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     xml_text(words));
}

/// Color of a wall: blue at rest, from yellow at 2 mm/s to dark red at 100 mm/s and more. Readable without
/// colors too: walls at rest are darker than slightly shaking ones, and have no dot.
std::string color(const haptics::WallVerdict& verdict) {
  constexpr double kShades = 6;  // few, so that neighboring walls share a rectangle
  if (verdict.stable) return "#3b7fb5";
  const double decades = std::clamp(std::log10(verdict.speed / 0.002) / std::log10(50.0), 0.0, 1.0);
  const double fraction = std::round(kShades * decades) / kShades;
  return fmt::format("#{:02x}{:02x}{:02x}", int(250 - 90 * fraction), int(200 - 180 * fraction),
                     int(90 - 60 * fraction));
}

double width(const HapticsBench& bench) { return kCellWide * double(bench.stiffness.size()); }
double height(const HapticsBench& bench) { return kCellHigh * double(bench.damping.size()); }

/// Column of a stiffness, as a real number; 0 is the center of the first column.
double column(const HapticsBench& bench, double stiffness) {
  const double decades = std::log(bench.stiffness.back() / bench.stiffness.front());
  return std::log(stiffness / bench.stiffness.front()) / decades * double(bench.stiffness.size() - 1);
}

/// A stiffness for each damping, drawn as a stepped line.
template <class Bound>
std::string steps(const HapticsBench& bench, Panel at, const char* dashes, const Bound& stiffness) {
  std::string path;
  for (std::size_t b = 0; b < bench.damping.size(); b++) {
    const double k = stiffness(bench.damping[b]);
    if (k < bench.stiffness.front() || k > bench.stiffness.back()) continue;
    const double x = at.x + kCellWide * (column(bench, k) + 0.5);
    const double low = at.y + height(bench) - kCellHigh * double(b);
    path += fmt::format("{}{:.1f} {:.1f}V{:.1f}", path.empty() ? "M" : "L", x, low, low - kCellHigh);
  }
  if (path.empty()) return "";
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"#ffffff\" stroke-width=\"2.5\" stroke-dasharray=\"{}\"/>\n",
      path, dashes);
}

/// Colgate's bound, and the bound K = 2 (b + B)/T for rest. T is the time for which a force is held.
std::string bounds(const HapticsBench& bench, const ZWidthMap& map, Panel at) {
  const double period =
      map.answer == haptics::WallAnswer::kHeld ? 1 / map.frame_rate : 1 / bench.trial.arm.rate;
  const double arm = bench.trial.arm.viscous, both = arm + bench.trial.hand_damping;
  return steps(bench, at, "none", [&](double b) { return haptics::colgate_stiffness(arm, b, period); }) +
         steps(bench, at, "4 3", [&](double b) { return haptics::resting_stiffness(both, b, period); });
}

std::string axes(const HapticsBench& bench, Panel at) {
  std::string svg;
  const double bottom = at.y + height(bench);
  for (const double k : {100.0, 300.0, 1000.0, 3000.0, 10000.0, 30000.0, 100000.0})
    svg += text(at.x + kCellWide * (column(bench, k) + 0.5), bottom + 16, "middle",
                k < 1000 ? fmt::format("{:g}", k) : fmt::format("{:g}k", k / 1000));
  for (std::size_t b = 0; b < bench.damping.size(); b++)
    if (b % 2 == 0 || b + 1 == bench.damping.size())
      svg += text(at.x - 6, bottom - kCellHigh * (double(b) + 0.5) + 4, "end",
                  fmt::format("{:g}", bench.damping[b]));
  return svg;
}

/// One row of walls. Neighbors of one color share a rectangle; dots cover the shaking walls.
std::string row(const HapticsBench& bench, const ZWidthMap& map, std::size_t b, Panel at) {
  const std::size_t columns = bench.stiffness.size();
  const double y = at.y + height(bench) - kCellHigh * double(b + 1);
  const auto verdict = [&](std::size_t k) -> const haptics::WallVerdict& {
    return map.verdicts[b * columns + k];
  };
  std::string svg;
  for (std::size_t begin = 0, end = 0; begin < columns; begin = end) {
    const std::string fill = color(verdict(begin));
    while (end < columns && color(verdict(end)) == fill) end++;
    const std::string rect =
        fmt::format("<rect x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\" ",
                    at.x + kCellWide * double(begin), y, kCellWide * double(end - begin), kCellHigh - 0.6);
    svg += fmt::format("{}fill=\"{}\"/>\n", rect, fill);
    if (!verdict(begin).stable) svg += rect + "fill=\"url(#dots)\"/>\n";
  }
  return svg;
}

std::string panel(const HapticsBench& bench, const ZWidthMap& map, Panel at) {
  std::string svg = text(at.x, at.y - 7, "start", map.name + (map.controller ? ", controller" : ""));
  for (std::size_t b = 0; b < bench.damping.size(); b++) svg += row(bench, map, b, at);
  return svg + bounds(bench, map, at) + axes(bench, at);
}

}  // namespace

std::string z_width_svg(const HapticsBench& bench) {
  const std::size_t rows = bench.maps.size() / 2;  // without the controller, then with it
  const double wide = kLeft + 2 * width(bench) + kGap + 20,
               high = kTop + double(rows) * (height(bench) + kPanelGap) - 6;
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 "
      "{0:.0f} "
      "{1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" font-family=\"system-ui, 'DejaVu Sans', "
      "sans-serif\" font-size=\"{2:.0f}\">\n<title>Z-width: walls on which a hand is stable</title>\n"
      "<style>text {{ fill: #43494f; }} @media (prefers-color-scheme: dark) {{ text {{ fill: #b9c0c7; }} "
      "}}</style>\n"
      "<defs><pattern id=\"dots\" width=\"10\" height=\"13\" patternUnits=\"userSpaceOnUse\"><circle "
      "cx=\"9\" "
      "cy=\"6.5\" r=\"1.3\" fill=\"#1a0505\"/></pattern></defs>\n",
      wide, high, kFont);
  svg += text(kLeft, 20, "start",
              "Walls on which a hand stays at rest (blue) or shakes (yellow to red, with a dot)");
  svg +=
      text(kLeft, 38, "start",
           "across: stiffness [N/m]; up: damping [N·s/m]; white: Colgate's bound; dashed: K = 2 (b + B)/T");
  for (std::size_t i = 0; i < bench.maps.size(); i++) {
    const Panel at{kLeft + double(i / rows) * (width(bench) + kGap),
                   kTop + double(i % rows) * (height(bench) + kPanelGap)};
    svg += panel(bench, bench.maps[i], at);
  }
  return svg + "</svg>\n";
}

}  // namespace turgor
