// turgor validate: runs a model where the right answer is known, prints ours beside it, and draws the curves
// and maps that the documents show.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/result_folder.hpp"
#include "app/validate_sfem.hpp"
#include "turgor/io/file.hpp"
#include "turgor/sim/report/plot.hpp"
#include "turgor/view/annotate.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct ValidateOptions {
  fs::path out = "out/validate-sfem";
  bool quick = false, force = false;
};

template <class T>
T required(Result<T> result) {
  if (!result) throw Failure{2, result.error().message};
  return std::move(*result);
}

double error_percent(double found, double expected) { return 100 * (found / expected - 1); }

void write_plot(const Plot& plot, const fs::path& folder, const std::string& file) {
  required(write_file(folder / file, plot_svg_file(plot)));
}

ordered_json report_plate(const std::vector<PlateRow>& rows) {
  fmt::print("The paper's plate, top centre 3 mm down: reaction [N]\n  {:<40}{:>12}{:>14}{:>14}{:>12}\n",
             "mesh", "local nodes", "independent", "turgor", "relative");
  ordered_json json = ordered_json::array();
  for (const PlateRow& row : rows) {
    fmt::print("  {:<40}{:>12}{:>14.6f}{:>14.6f}{:>12.1e}\n", row.mesh, row.local_nodes, row.expected,
               row.found, row.found / row.expected - 1);
    json.push_back({{"mesh", row.mesh},
                    {"local_nodes", row.local_nodes},
                    {"independent_n", row.expected},
                    {"turgor_n", row.found}});
  }
  return json;
}

ordered_json report_hertz(const HertzResult& hertz, const fs::path& folder) {
  fmt::print(
      "\nHertz: a rigid sphere of {:.0f} mm on a block of E = {:.0f} Pa, ν = {}; {} nodes, {} local\n"
      "  {:>10}{:>12}{:>14}{:>10}{:>16}{:>10}\n",
      1e3 * hertz.radius, hertz.young, hertz.poisson, hertz.nodes, hertz.local_nodes, "depth [mm]",
      "Hertz [N]", "with patch", "error", "without patch", "error");
  ordered_json rows = ordered_json::array();
  Plot plot{"A sphere on a half space", "depth [mm]", "force [N]", {}, false};
  Curve formula{"Hertz", {}}, with{"with the patch", {}}, without{"without", {}};
  for (const HertzRow& row : hertz.rows) {
    fmt::print("  {:>10.2f}{:>12.6f}{:>14.6f}{:>9.1f}%{:>16.6f}{:>9.1f}%\n", 1e3 * row.depth, row.hertz,
               row.patched, error_percent(row.patched, row.hertz), row.unpatched,
               error_percent(row.unpatched, row.hertz));
    formula.points.emplace_back(1e3 * row.depth, row.hertz);
    with.points.emplace_back(1e3 * row.depth, row.patched);
    without.points.emplace_back(1e3 * row.depth, row.unpatched);
    rows.push_back({{"depth_m", row.depth},
                    {"hertz_n", row.hertz},
                    {"with_patch_n", row.patched},
                    {"without_patch_n", row.unpatched}});
  }
  plot.curves = {formula, with, without};
  write_plot(plot, folder, "hertz.svg");
  return {{"nodes", hertz.nodes}, {"local_nodes", hertz.local_nodes}, {"rows", rows}};
}

ordered_json report_refinement(const std::vector<RefinementRow>& rows, const fs::path& folder) {
  const auto last_global =
      std::find_if(rows.rbegin(), rows.rend(), [](const auto& row) { return row.global; });
  const double reference = last_global->force_of_depth.back().second;
  fmt::print(
      "\nLocal against global refinement: a sphere of 10 mm pressed 3 mm into a block of 80 x 80 x 40 mm\n"
      "  {:<26}{:>8}{:>8}{:>12}{:>14}{:>16}{:>12}\n",
      "mesh", "nodes", "local", "force [N]", "to the finest", "Green's [s]", "patch [ms]");
  ordered_json json = ordered_json::array();
  Plot curves{"Force against depth", "depth [mm]", "force [N]", {}, false};
  Plot cost{
      "Error against cost", "time for Green's functions and patch [s]", "error to the finest mesh", {}, true};
  cost.curves = {
      {"the whole body finer", {}}, {"a finer patch on the coarsest body", {}}, {"on the next", {}}};
  int coarsest = rows.front().nodes;
  for (const RefinementRow& row : rows) {
    const double force = row.force_of_depth.back().second;
    fmt::print("  {:<26}{:>8}{:>8}{:>12.5f}{:>13.1f}%{:>16.2f}{:>12.2f}\n", row.mesh, row.nodes,
               row.local_nodes, force, error_percent(force, reference), row.precompute, 1e3 * row.rebuild);
    Curve curve{row.mesh, {}};
    for (const auto& [d, f] : row.force_of_depth) curve.points.emplace_back(1e3 * d, f);
    curves.curves.push_back(curve);
    if (&row != &*last_global) {
      const std::size_t kind = row.global ? 0 : row.nodes == coarsest ? 1 : 2;
      cost.curves[kind].points.emplace_back(row.precompute + row.rebuild, std::abs(force / reference - 1));
    }
    json.push_back({{"mesh", row.mesh},
                    {"nodes", row.nodes},
                    {"local_nodes", row.local_nodes},
                    {"force_n", force},
                    {"green_s", row.precompute},
                    {"patch_s", row.rebuild}});
  }
  write_plot(curves, folder, "refinement-force.svg");
  write_plot(cost, folder, "refinement-cost.svg");
  return json;
}

/// A field of forces as colours, with a ring where the nodule lies.
Image draw_map(const NoduleResult& result, const NoduleMap& map, const ColorScale& scale) {
  constexpr int kSize = 420, kLegend = 110;
  Image image = make_image(kSize + kLegend, kSize, {24, 28, 34});
  const double extent = result.high - result.low;
  for (int py = 0; py < kSize; py++)
    for (int px = 0; px < kSize; px++) {
      // Between the places where the tool pressed, as they are: bilinear.
      const double x = (px + 0.5) / kSize * (result.columns - 1),
                   y = (kSize - py - 0.5) / kSize * (result.rows - 1);
      const int i = std::min(int(x), result.columns - 2), j = std::min(int(y), result.rows - 2);
      const double u = x - i, v = y - j;
      const auto at = [&](int a, int b) {
        return map.force[std::size_t(j + b) * std::size_t(result.columns) + std::size_t(i + a)];
      };
      const double force =
          (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
      image.at(px, py) = map_color(scale_fraction(scale, float(force)));
      const double wx = result.low + (px + 0.5) / kSize * extent - result.centre_x;
      const double wy = result.low + (kSize - py - 0.5) / kSize * extent - result.centre_y;
      if (std::abs(std::hypot(wx, wy) - result.radius) < 0.6 * extent / kSize)
        image.at(px, py) = {255, 255, 255};
    }
  draw_legend(image, scale);
  return image;
}

/// Where the force is largest, and how much it stands out from the border of the field.
struct Peak {
  double x = 0, y = 0, contrast = 0;
};
Peak find_peak(const NoduleResult& result, const NoduleMap& map) {
  const auto largest = std::max_element(map.force.begin(), map.force.end()) - map.force.begin();
  const double step = (result.high - result.low) / (result.columns - 1);
  std::vector<double> border;
  for (int i = 0; i < result.columns; i++) {
    border.push_back(map.force[std::size_t(i)]);
    border.push_back(map.force[map.force.size() - 1 - std::size_t(i)]);
  }
  return {result.low + double(largest % result.columns) * step,
          result.low + double(largest / result.columns) * step,
          map.force[std::size_t(largest)] / median(border) - 1};
}

ordered_json report_nodule(const NoduleResult& result, const fs::path& folder) {
  fmt::print(
      "\nA nodule of {:.0f} mm, its centre {:.0f} mm below the surface at ({:.1f}, {:.1f}) mm: force 3 mm "
      "deep\n"
      "  {:<24}{:>8}{:>22}{:>12}{:>22}\n",
      2e3 * result.radius, 1e3 * result.depth, 1e3 * result.centre_x, 1e3 * result.centre_y, "mesh", "nodes",
      "peak at [mm]", "stands out", "differs from fine");
  float low = 1e9f, high = 0;
  for (const NoduleMap& map : result.maps)
    for (const double f : map.force) low = std::min(low, float(f)), high = std::max(high, float(f));
  const ColorScale scale{low, high, "force [mN]", 1000};
  std::vector<Image> images;
  std::vector<std::string> captions;
  ordered_json json = ordered_json::array();
  const NoduleMap& fine = result.maps.back();
  for (const NoduleMap& map : result.maps) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < map.force.size(); i++)
      difference += std::abs(map.force[i] - fine.force[i]), sum += fine.force[i];
    const Peak peak = find_peak(result, map);
    fmt::print("  {:<24}{:>8}{:>22}{:>11.0f}%{:>21.1f}%\n", map.mesh, map.nodes,
               fmt::format("({:.1f}, {:.1f})", 1e3 * peak.x, 1e3 * peak.y), 100 * peak.contrast,
               100 * difference / sum);
    images.push_back(draw_map(result, map, scale));
    captions.push_back(map.mesh);
    json.push_back({{"mesh", map.mesh},
                    {"nodes", map.nodes},
                    {"peak_m", {peak.x, peak.y}},
                    {"contrast", peak.contrast},
                    {"mean_difference_from_fine", difference / sum},
                    {"force_n", map.force}});
  }
  required(write_png(folder / "nodule-map.png", side_by_side(images, captions)));
  return json;
}

void validate_all(const Exec& exec, const ValidateOptions& options) {
  OutputFolder folder = open_result_folder(options.out, options.force);
  ordered_json report;
  report["plate"] = report_plate(required(validate_plate(exec)));
  report["hertz"] = report_hertz(required(validate_hertz(exec)), folder.path());
  {
    ProgressBar bar("refining");
    report["refinement"] =
        report_refinement(required(validate_refinement(exec, !options.quick, bar.callback())), folder.path());
  }
  {
    ProgressBar bar("palpating");
    report["nodule"] =
        report_nodule(required(validate_nodule(exec, options.quick ? 9 : 17, bar.callback())), folder.path());
  }
  required(write_file(folder.path() / kReportFile, report.dump(1) + "\n"));
  commit_results(folder);
  fmt::print("\ncurves, maps and numbers   {}\n", folder.goal().string());
}

}  // namespace

void add_validate_command(CLI::App& program, Global& global) {
  CLI::App* validate =
      program.add_subcommand("validate", "Run a model where the right answer is known, ours beside it");
  validate->require_subcommand(1);
  CLI::App* sfem = validate->add_subcommand("sfem", "Plate, Hertz, refinement, a nodule under the finger");
  auto options = std::make_shared<ValidateOptions>();
  sfem->add_option("-o,--out", options->out, "Folder for curves, maps and numbers")->capture_default_str();
  sfem->add_flag("--quick", options->quick, "Without the finest meshes, with fewer places");
  add_force_option(*sfem, options->force);
  for (CLI::App* app : {validate, sfem}) app->footer("Example:\n  turgor validate sfem --out out/validation");
  sfem->callback([options, &global] { validate_all(Exec(global.threads), *options); });
}

}  // namespace turgor
