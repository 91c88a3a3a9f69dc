#include "app/plan_page.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/xml_text.hpp"
#include "turgor/sim/report/page.hpp"

namespace turgor {

namespace {

constexpr double kPolarSize = 460, kPolarRadius = 180;  // [pixels]

double largest_force(const std::vector<PlannedExcision>& found) {
  double most = 0;
  for (const PlannedExcision& d : found) most = std::max(most, d.closing_force);
  return most > 0 ? most : 1;
}

/// Excisions of one shape, in the order of their directions.
using Shape = std::span<const PlannedExcision>;
std::vector<Shape> shapes_of(Shape found) {
  std::vector<Shape> shapes;
  for (std::size_t begin = 0, end = 0; begin < found.size(); begin = end) {
    while (end < found.size() && found[end].length == found[begin].length) end++;
    shapes.push_back(found.subspan(begin, end - begin));
  }
  return shapes;
}
constexpr const char* kShapeColors[] = {"#0072b2", "#cc79a7", "#e69f00", "#56b4e9"};

std::string ratio_text(const PlannedExcision& excision) { return fmt::format("{:.3g}", excision.ratio()); }

struct PolarPoint {
  double x, y;
};
/// Point of the plot in a direction, counter-clockwise from the right, at a fraction of the radius.
PolarPoint polar_point(double degrees, double fraction) {
  const double angle = degrees * std::numbers::pi / 180, r = kPolarRadius * fraction;
  return {kPolarSize / 2 + r * std::cos(angle), kPolarSize / 2 - r * std::sin(angle)};
}

/// Curve of one shape, and its directions; hollow = the wound stays open.
std::string curve_svg(Shape shape, double most, const char* color) {
  std::string points, circles;
  // a lens looks the same after half a turn
  for (const double turn : {0.0, 180.0})
    for (const PlannedExcision& d : shape) {
      if (!d.problem.empty()) continue;
      const PolarPoint at = polar_point(d.angle + turn, std::max(0.0, d.closing_force / most));
      points += fmt::format("{:.1f},{:.1f} ", at.x, at.y);
      circles += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\" fill=\"{}\" stroke=\"{}\" stroke-width=\"2\"/>\n",
          at.x, at.y, d.is_closed ? color : "#ffffff", color);
    }
  return fmt::format(
             "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"0.12\" stroke=\"{}\" "
             "stroke-width=\"2\"/>\n",
             points, color, color) +
         circles;
}

/// Colors and ratios of several shapes.
std::string legend_svg(const std::vector<Shape>& shapes) {
  std::string svg;
  for (std::size_t n = 0; shapes.size() > 1 && n < shapes.size(); n++)
    svg += fmt::format("<text x=\"6\" y=\"{:.0f}\" fill=\"{}\">length/width {}</text>\n", 18 + 17 * double(n),
                       kShapeColors[n % std::size(kShapeColors)], ratio_text(shapes[n].front()));
  return svg;
}

}  // namespace

PlanVerdict verdict_of(const std::vector<PlannedExcision>& found) {
  TURGOR_ASSERT(!found.empty(), "a plan has directions");
  // directions that could not be simulated are neither best nor worst; a wound that stays open needs a larger
  // force than was found, so that it is not best beside one that closes
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  PlanVerdict verdict;
  verdict.has_closed =
      std::any_of(found.begin(), found.end(), [](const PlannedExcision& d) { return d.is_closed; });
  const auto at_best = [&](const PlannedExcision& d) {
    return d.problem.empty() && (d.is_closed || !verdict.has_closed) ? d.closing_force : kUnknown;
  };
  const auto at_worst = [](const PlannedExcision& d) {
    return d.problem.empty() ? d.closing_force : -kUnknown;
  };
  for (std::size_t n = 1; n < found.size(); n++) {
    if (at_best(found[n]) < at_best(found[verdict.best])) verdict.best = n;
    if (at_worst(found[n]) > at_worst(found[verdict.worst])) verdict.worst = n;
  }
  const PlannedExcision &best = found[verdict.best], &worst = found[verdict.worst];
  if (!(best.closing_force > 0)) {
    verdict.sentence = "No closing force was measured: the stitches did not close the wound before the end.";
    return verdict;
  }
  verdict.ratio = worst.closing_force / best.closing_force;
  const bool has_shapes = shapes_of(found).size() > 1;
  const auto with_ratio = [has_shapes](const PlannedExcision& d) {
    return has_shapes ? " with a ratio of " + ratio_text(d) : std::string();
  };
  verdict.sentence =
      verdict.has_closed
          ? fmt::format(
                "The wound closes with least force at {:.0f} degrees{}: {:.2f} N{}. The worst direction, "
                "{:.0f} degrees{}, needs {:.2f} N, {:.0f} % more.",
                best.angle, with_ratio(best), best.closing_force,
                best.is_directional ? fmt::format(", {:.0f} degrees from Langer's lines", best.angle_to_lines)
                                    : "",
                worst.angle, with_ratio(worst), worst.closing_force, 100 * (verdict.ratio - 1))
          : fmt::format(
                "The wound stays open in every direction, under {:.2f} to {:.2f} N. A larger bite, "
                "more stitches or a finer lattice may close it.",
                best.closing_force, worst.closing_force);
  int lost = 0, open = 0, unknown = 0;
  for (const PlannedExcision& d : found) {
    unknown += !d.problem.empty();
    lost += d.lost, open += d.problem.empty() && d.lost == 0 && !d.is_closed;
  }
  if (unknown > 0)
    verdict.sentence += fmt::format(" {} of {} directions could not be simulated.", unknown, found.size());
  if (open > 0 && verdict.has_closed)
    verdict.sentence += fmt::format(
        " The stitches did not close the wound in {} of {} directions: the forces there are too small.", open,
        found.size());
  if (lost > 0)
    verdict.sentence +=
        fmt::format(" {} stitches tore out or broke: the forces in their directions are too small.", lost);
  return verdict;
}

std::string polar_svg(const std::vector<PlannedExcision>& found, const PlanVerdict& verdict) {
  const double most = largest_force(found);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {0:.0f}\" font-family=\"sans-serif\" "
      "font-size=\"13\" fill=\"currentColor\" role=\"img\" aria-label=\"closing force over direction\">\n",
      kPolarSize);
  // rings with forces, and spokes with angles
  for (const double ring : {0.25, 0.5, 0.75, 1.0}) {
    svg += fmt::format(
        "<circle cx=\"{0:.1f}\" cy=\"{0:.1f}\" r=\"{1:.1f}\" fill=\"none\" stroke=\"currentColor\" "
        "stroke-opacity=\"0.2\"/>\n",
        kPolarSize / 2, kPolarRadius * ring);
    const PolarPoint at = polar_point(97, ring);
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" opacity=\"0.7\" text-anchor=\"end\">{:.3g} N</text>\n",
                    at.x, at.y + 4, most * ring);
  }
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const PolarPoint end = polar_point(degrees, 1), label = polar_point(degrees, 1.12);
    svg += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{0:.1f}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"currentColor\" "
        "stroke-opacity=\"0.12\"/>\n<text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"middle\">{5}°</text>\n",
        kPolarSize / 2, end.x, end.y, label.x, label.y + 4, degrees);
  }
  // curves
  const std::vector<Shape> shapes = shapes_of(found);
  for (std::size_t n = 0; n < shapes.size(); n++)
    svg += curve_svg(shapes[n], most, kShapeColors[n % std::size(kShapeColors)]);
  svg += legend_svg(shapes);
  // best and worst direction
  if (!verdict.has_closed) return svg + "</svg>\n";
  for (const auto& [index, color] :
       {std::pair(verdict.best, "#009e73"), std::pair(verdict.worst, "#d55e00")}) {
    const PolarPoint a = polar_point(found[index].angle, 1), b = polar_point(found[index].angle + 180, 1);
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"2.5\" "
        "stroke-dasharray=\"7 5\"/>\n",
        a.x, a.y, b.x, b.y, color);
  }
  return svg + "</svg>\n";
}

std::string plan_page(const std::string& name, const std::vector<PlannedExcision>& found,
                      const PlanVerdict& verdict) {
  std::string html =
      page::page_head(xml_text("Excision " + name)) + "<h1>" + xml_text("Excision " + name) +
      "</h1>\n<p class=\"verdict\">" + xml_text(verdict.sentence) +
      "</p>\n<div class=\"grid\"><div class=\"plot\">" + polar_svg(found, verdict) +
      "</div><div><p class=\"soft\">Closing force over the direction of the length, "
      "counter-clockwise seen from outside. Green: least force. Orange: largest force. Hollow: the wound "
      "stays open. Stretch: of the most stretched disc of skin of 5 mm radius, relative to the CT.</p></div>"
      "</div>\n<div class=\"scroll\"><table>\n" +
      page::table_row({"length/width", "direction [°]", "to Langer's lines [°]", "closing force [N]",
                       "largest thread [N]", "gape [mm]", "dog ear [mm]", "stretch", "specimen shrinks [%]"},
                      "th");
  for (const PlannedExcision& d : found) {
    if (!d.problem.empty()) {
      html += fmt::format("<tr><td>{}</td><td>{:.0f}</td><td colspan=\"7\">{}</td></tr>\n", ratio_text(d),
                          d.angle, xml_text(d.problem));
      continue;
    }
    html += page::table_row({ratio_text(d), fmt::format("{:.0f}", d.angle),
                             d.is_directional ? fmt::format("{:.0f}", d.angle_to_lines) : "–",
                             fmt::format("{:.3f}", d.closing_force), fmt::format("{:.3f}", d.tension_max),
                             fmt::format("{:.2f}{}", 1e3 * d.gape, d.is_closed ? "" : " (open)"),
                             fmt::format("{:.2f}", 1e3 * d.dog_ear), fmt::format("{:.3f}", d.stretch),
                             fmt::format("{:.1f}", 100 * d.shrinkage)},
                            "td");
  }
  return html + "</table></div>\n" + page::page_end();
}

}  // namespace turgor
