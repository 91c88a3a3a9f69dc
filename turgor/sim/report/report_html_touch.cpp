// Bodies and tools on the report's page.
#include <fmt/format.h>

#include "turgor/sim/report/page.hpp"

namespace turgor::page {

namespace {

/// Plot of one column of all tool series over another.
Plot tool_plot(const Json& tools, const char* title, const char* x_label, const char* y_label, const char* x,
               const char* y) {
  Plot plot{title, x_label, y_label, {}};
  for (const Json& tool : tools)
    plot.curves.push_back(curve_of(tool.at("name").get<std::string>(), tool, {}, x, y));
  return plot;
}

/// Marks intervals in which tools were above an inclusion.
Plot with_inclusion_marks(Plot plot, const Json& tools, const char* from, const char* to) {
  for (const Json& tool : tools)
    for (const Json& over : tool.value("over", Json::array()))
      plot.bands.push_back({"over " + over.at("inclusion").get<std::string>(), over.at(from).get<double>(),
                            over.at(to).get<double>()});
  return plot;
}

/// Removes points without contact.
void keep_touching(Plot& plot) {
  for (Curve& curve : plot.curves)
    std::erase_if(curve.points, [](const auto& point) { return !(point.first > 0); });
}

Plot profile_plot(const Json& profiles) {
  Plot plot{"Displacement under the largest force",
            "distance from the deepest point [mm]",
            "displacement [mm]",
            {}};
  for (const Json& body : profiles)
    plot.curves.push_back(curve_of(body.at("name").get<std::string>(), body, {"columns", "rows"},
                                   "distance_mm", "displacement_mm"));
  return plot;
}

/// Force of every needle over its depth, with its parts.
std::string needle_plots(const Json& tools) {
  std::string html;
  for (const Json& tool : tools) {
    if (!tool.contains("needle")) continue;
    Plot plot{"Needle " + tool.at("name").get<std::string>(),
              "depth of the tip [mm]",
              "force along the needle [N]",
              {}};
    const std::pair<const char*, const char*> kParts[] = {{"whole force", "force_N"},
                                                          {"cutting", "cutting_N"},
                                                          {"spreading", "spreading_N"},
                                                          {"friction", "friction_N"}};
    for (const auto& [label, column] : kParts)
      plot.curves.push_back(curve_of(label, tool.at("needle"), {}, "depth_mm", column));
    keep_touching(plot);
    for (const Json& layer : tool.at("needle").value("layers", Json::array()))
      plot.bands.push_back(
          {layer.at(0).get<std::string>(), layer.at(3).get<double>(), layer.at(4).get<double>()});
    html += plot_html(plot);
    if (!tool.at("needle").contains("deflection_max_mm")) continue;
    Plot bent{"Deflection of needle " + tool.at("name").get<std::string>(),
              "depth of the tip [mm]",
              "deflection of the tip [mm]",
              {}};
    bent.curves.push_back(curve_of("deflection", tool.at("needle"), {}, "depth_mm", "deflection_mm"));
    keep_touching(bent);
    html += plot_html(bent);
  }
  return html;
}

}  // namespace

std::string touch_curves(const Json& report) {
  const Json& tools = report.value("tools", Json::array());
  if (tools.empty()) return "";
  // force over depth, in contact only
  Plot depth = tool_plot(tools, "Force over depth", "depth below the surface at rest [mm]", "force [N]",
                         "depth_mm", "force_N");
  keep_touching(depth);
  // assemble the section
  return "<h2>Contact</h2>\n<div class=\"grid\">" +
         plot_html(with_inclusion_marks(
             tool_plot(tools, "Force over time", "time [s]", "force [N]", "time_s", "force_N"), tools,
             "from_s", "to_s")) +
         plot_html(with_inclusion_marks(tool_plot(tools, "Force along the path", "path of the tool [mm]",
                                                  "force [N]", "path_mm", "force_N"),
                                        tools, "from_mm", "to_mm")) +
         plot_html(depth) + needle_plots(tools) +
         plot_html(tool_plot(tools, "Contacts", "time [s]", "contact sites", "time_s", "contacts")) +
         plot_html(profile_plot(report.value("profiles", Json::array()))) + "</div>\n";
}

}  // namespace turgor::page
