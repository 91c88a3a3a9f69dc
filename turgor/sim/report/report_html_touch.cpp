// What the report's page says about bodies and tools.
#include <fmt/format.h>

#include "turgor/sim/report/page.hpp"

namespace turgor {

namespace {

using page::curve_of, page::drawn, page::key_figure, page::quantity_table, page::shown;

/// A plot of one column of every tool's series over another.
Plot tool_plot(const Json& tools, const char* title, const char* x_label, const char* y_label, std::size_t x,
               std::size_t y) {
  Plot plot{title, x_label, y_label, {}};
  for (const Json& tool : tools)
    plot.curves.push_back(curve_of(tool.at("name").get<std::string>(), tool.at("series"), x, y));
  return plot;
}

/// Points are drawn while the tool touches: it moves through air at no force before and after.
void keep_touching(Plot& plot) {
  for (Curve& curve : plot.curves)
    std::erase_if(curve.points, [](const auto& point) { return !(point.first > 0); });
}

Plot rebuild_plot(const Json& bodies) {
  Plot plot{"Building a patch", "time [s]", "wall time [ms]", {}};
  for (const Json& body : bodies)
    plot.curves.push_back(curve_of(body.at("name").get<std::string>(), body.at("patch").at("series"), 0, 1));
  return plot;
}

Plot profile_plot(const Json& profiles) {
  Plot plot{
      "The dent under the largest force", "distance from the deepest place [mm]", "displacement [mm]", {}};
  for (const Json& body : profiles)
    plot.curves.push_back(curve_of(body.at("name").get<std::string>(), body.at("rows"), 0, 1));
  return plot;
}

}  // namespace

std::string touch_figures(const Json& report) {
  std::string html;
  for (const Json& tool : report.value("tools", Json::array())) {
    const std::string name = shown(tool.at("name"));
    html += key_figure(shown(tool.at("force_max_N")) + " N", "largest force on " + name);
    html += key_figure(shown(tool.at("depth_max_mm")) + " mm", "deepest press of " + name);
    const bool by_frame = tool.value("force_every_ms", 1.0) > 1;
    const std::string what = by_frame ? "a frame of the body, one force (" : "a haptic tick (";
    const auto time = [&](const char* key) {
      const double us = tool.at(key).get<double>();
      return us < 1000 ? fmt::format("{:.3g} µs", us) : fmt::format("{:.3g} ms", us * 1e-3);
    };
    html += key_figure(time("tick_p50_us"), what + "median)");
    html += key_figure(time("tick_p99_us"), what + "99 of 100)");
  }
  return html;
}

std::string touch_curves(const Json& report) {
  const Json& tools = report.value("tools", Json::array());
  if (tools.empty()) return "";
  Plot depth =
      tool_plot(tools, "Force over depth", "depth below the surface at rest [mm]", "force [N]", 2, 1);
  keep_touching(depth);
  return "<h2>The touch</h2>\n<div class=\"grid\">" +
         drawn(tool_plot(tools, "Force over time", "time [s]", "force [N]", 0, 1)) +
         drawn(tool_plot(tools, "Force along the path", "path of the tool [mm]", "force [N]", 3, 1)) +
         drawn(depth) + drawn(tool_plot(tools, "Contacts", "time [s]", "places that bear force", 0, 4)) +
         drawn(profile_plot(report.value("profiles", Json::array()))) +
         drawn(rebuild_plot(bodies_of(report, BodyKind::kSfem))) + "</div>\n";
}

std::string touch_tables(const Json& report) {
  std::string html;
  if (!report.value("tools", Json::array()).empty())
    html += "<h2>Tools</h2>\n" + quantity_table(report.value("tools", Json::array()), "tool",
                                                {{"body", "touches"},
                                                 {"shape", "shape"},
                                                 {"friction", "friction"},
                                                 {"force_max_N", "largest force [N]"},
                                                 {"force_max_at_s", "… at [s]"},
                                                 {"depth_max_mm", "deepest press [mm]"},
                                                 {"contacts_max", "places that bear force, most"},
                                                 {"force_every_ms", "a force every [ms]"},
                                                 {"ticks", "forces"},
                                                 {"tick_p50_us", "one of them, median [µs]"},
                                                 {"tick_p99_us", "… 99 of 100 [µs]"},
                                                 {"tick_max_us", "… longest [µs]"}});
  if (const Json costs = report.value("costs", Json::array()); costs.size() > 1)
    html += "<h2>Side by side</h2>\n" + quantity_table(costs, "body",
                                                       {{"model", "model"},
                                                        {"force_max_N", "largest force [N]"},
                                                        {"force_max_at_s", "… at [s]"},
                                                        {"depth_max_mm", "deepest press [mm]"},
                                                        {"displacement_max_mm", "deepest dent [mm]"},
                                                        {"build_s", "reading and building [s]"},
                                                        {"force_every_ms", "a force every [ms]"},
                                                        {"force_p50_ms", "… takes, median [ms]"},
                                                        {"force_p99_ms", "… 99 of 100 [ms]"},
                                                        {"surface_p50_ms", "surface for a picture [ms]"}});
  if (!bodies_of(report, BodyKind::kSfem).empty())
    html += "<h2>Bodies</h2>\n" +
            quantity_table(bodies_of(report, BodyKind::kSfem), "body",
                           {{"source", "made from"},
                            {"young_Pa", "Young's modulus [Pa]"},
                            {"poisson", "Poisson's ratio"},
                            {"formulation", "elements"},
                            {"mesh.vertices", "nodes"},
                            {"mesh.free_nodes", "… free to move"},
                            {"mesh.kept_nodes", "… with Green's functions"},
                            {"mesh.elements", "elements of the mesh"},
                            {"mesh.surface_triangles", "triangles of the surface"},
                            {"mesh.volume_ml", "volume [ml]"},
                            {"mesh.volume_error_percent", "… against the input [%]"},
                            {"mesh.min_dihedral_deg", "smallest dihedral angle [°]"},
                            {"mesh.max_dihedral_deg", "largest dihedral angle [°]"},
                            {"green.store_bytes", "Green's functions [bytes]"},
                            {"green.seconds", "… computed or read in [s]"},
                            {"patch.local_nodes_most", "local nodes of the patch, most"},
                            {"patch.rebuilds", "patches built"},
                            {"patch.rebuild_p50_ms", "… median [ms]"},
                            {"patch.rebuild_max_ms", "… longest [ms]"},
                            {"patch.rebuilds_too_late", "… that would have come too late"},
                            {"patch.handover_max_ms", "longest hand-over, within a tick [ms]"},
                            {"patch.force_jump_max_N", "largest jump of the force at a hand-over [N]"},
                            {"surface_p50_ms", "surface for a picture [ms]"}});
  if (!bodies_of(report, BodyKind::kRhombus).empty())
    html += "<h2>Bodies of rhombus chains</h2>\n" +
            quantity_table(bodies_of(report, BodyKind::kRhombus), "body",
                           {{"source", "made from"},
                            {"tissue", "tissue"},
                            {"vertices", "vertices"},
                            {"triangles", "triangles"},
                            {"volume_ml", "volume [ml]"},
                            {"normal_N_per_m", "k_N [N/m]"},
                            {"tangential_N_per_m", "k_T of the first unit [N/m]"},
                            {"decay", "β"},
                            {"angle_deg", "θ [°]"},
                            {"side_mm", "side of the rhombi [mm]"},
                            {"bulge", "volume that bulges"},
                            {"pressed_volume_ml", "volume pressed in, most [ml]"},
                            {"jump_per_10_um_N", "largest jump of a force per 10 µm [N]"},
                            {"jump_at_s", "… at [s]"},
                            {"build_s", "building [s]"},
                            {"surface_p50_ms", "surface for a picture [ms]"}});
  return html;
}

}  // namespace turgor
