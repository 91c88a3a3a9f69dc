// `turgor validate`: runs models on cases with known answers and prints results, references and bounds. Draws
// the curves and maps of the documents. Exits with 3 if a figure exceeds its bound.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/other_programs.hpp"
#include "app/print.hpp"
#include "app/report_elements.hpp"
#include "app/result_folder.hpp"
#include "app/validate_measured.hpp"
#include "app/validate_sfem.hpp"
#include "app/validate_surgery.hpp"
#include "app/validation.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/view/annotate.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kMissed = 3;  // exit code: a figure exceeds its bound

struct ValidateOptions {
  fs::path out;
  bool quick = false, force = false;
};

double error_percent(double found, double expected) { return 100 * (found / expected - 1); }

void write_plot(const Plot& plot, const fs::path& folder, const std::string& file) {
  required(write_file(folder / file, plot_svg_file(plot)));
}

ordered_json report_plate(const std::vector<PlateRow>& rows) {
  print_plain("The paper's plate, top center pressed 3 mm: reaction [N]\n  {:<40}{:>12}{:>14}{:>14}{:>12}\n",
              "mesh", "local nodes", "independent", "turgor", "relative");
  ordered_json json = ordered_json::array();
  for (const PlateRow& row : rows) {
    print_plain("  {:<40}{:>12}{:>14.6f}{:>14.6f}{:>12.1e}\n", row.mesh, row.local_nodes, row.expected,
                row.found, row.found / row.expected - 1);
    json.push_back({{"mesh", row.mesh},
                    {"local_nodes", row.local_nodes},
                    {"independent_n", row.expected},
                    {"turgor_n", row.found}});
  }
  return json;
}

ordered_json report_hertz(const HertzResult& hertz, const fs::path& folder) {
  print_plain(
      "\nHertz: a rigid sphere of {:.0f} mm on a block of E = {:.0f} Pa, ν = {}; {} nodes, {} local\n"
      "  {:>10}{:>12}{:>14}{:>10}{:>16}{:>10}\n",
      1e3 * hertz.radius, hertz.young, hertz.poisson, hertz.nodes, hertz.local_nodes, "depth [mm]",
      "Hertz [N]", "with patch", "error", "without patch", "error");
  ordered_json rows = ordered_json::array();
  Plot plot{"A sphere on a half space", "depth [mm]", "force [N]", {}, false};
  Curve formula{"Hertz", {}}, with{"with the patch", {}}, without{"without", {}};
  for (const HertzRow& row : hertz.rows) {
    print_plain("  {:>10.2f}{:>12.6f}{:>14.6f}{:>9.1f}%{:>16.6f}{:>9.1f}%\n", 1e3 * row.depth, row.hertz,
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
  print_plain(
      "\nLocal against global refinement: a sphere of 10 mm pressed 3 mm into a block of 80 x 80 x 40 mm\n"
      "  {:<26}{:>8}{:>8}{:>12}{:>14}{:>16}{:>12}\n",
      "mesh", "nodes", "local", "force [N]", "vs finest", "Green's [s]", "patch [ms]");
  ordered_json json = ordered_json::array();
  Plot curves{"Force against depth", "depth [mm]", "force [N]", {}, false};
  Plot cost{"Error against cost",
            "time for Green's functions and patch [s]",
            "error against the finest mesh",
            {},
            true};
  cost.curves = {
      {"whole body refined", {}}, {"patch on the coarsest body", {}}, {"patch on the next body", {}}};
  int coarsest = rows.front().nodes;
  for (const RefinementRow& row : rows) {
    const double force = row.force_of_depth.back().second;
    print_plain("  {:<26}{:>8}{:>8}{:>12.5f}{:>13.1f}%{:>16.2f}{:>12.2f}\n", row.mesh, row.nodes,
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

/// Draws a force field in colors, with a ring at the nodule.
Image draw_map(const NoduleResult& result, const NoduleMap& map, const ColorScale& scale) {
  constexpr int kSize = 420, kLegend = 110;
  Image image = make_image(kSize + kLegend, kSize, {24, 28, 34});
  const double extent = result.high - result.low;
  for (int py = 0; py < kSize; py++)
    for (int px = 0; px < kSize; px++) {
      // Bilinear between the pressed points, without smoothing.
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
      const double wx = result.low + (px + 0.5) / kSize * extent - result.center_x;
      const double wy = result.low + (kSize - py - 0.5) / kSize * extent - result.center_y;
      if (std::abs(std::hypot(wx, wy) - result.radius) < 0.6 * extent / kSize)
        image.at(px, py) = {255, 255, 255};
    }
  draw_legend(image, scale);
  return image;
}

/// Location of the largest force, and its contrast to the border of the field.
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
  print_plain(
      "\nA nodule of {:.0f} mm, its center {:.0f} mm below the surface at ({:.1f}, {:.1f}) mm: force 3 mm "
      "deep\n"
      "  {:<24}{:>8}{:>22}{:>12}{:>22}\n",
      2e3 * result.radius, 1e3 * result.depth, 1e3 * result.center_x, 1e3 * result.center_y, "mesh", "nodes",
      "peak at [mm]", "contrast", "difference to fine");
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
    print_plain("  {:<24}{:>8}{:>22}{:>11.0f}%{:>21.1f}%\n", map.mesh, map.nodes,
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

/// Figures of the tables above, with bounds.
std::vector<Figure> sfem_figures(const std::vector<PlateRow>& plate, const HertzResult& hertz,
                                 const std::vector<RefinementRow>& refinement, const NoduleResult& nodule) {
  std::vector<Figure> figures;
  for (const PlateRow& row : plate)
    figures.push_back(
        near_figure("plate, " + row.mesh, "an independent program", row.found, row.expected, 1e-6));
  for (const HertzRow& row : hertz.rows)
    figures.push_back(near_figure(fmt::format("sphere {:.2f} mm deep, with the patch", 1e3 * row.depth),
                                  "Hertz", row.patched, row.hertz, 0.03));
  const auto finest =
      std::find_if(refinement.rbegin(), refinement.rend(), [](const auto& row) { return row.global; });
  for (const RefinementRow& row : refinement)
    if (!row.global)
      figures.push_back(near_figure("sphere on " + row.mesh, "the finest mesh",
                                    row.force_of_depth.back().second, finest->force_of_depth.back().second,
                                    row.mesh.find("8 x 8 x 4, patch r = 2") == 0 ? 0.10 : 0.05));
  const NoduleMap &superposed = nodule.maps[1], &fine = nodule.maps.back();
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < fine.force.size(); i++)
    difference += std::abs(superposed.force[i] - fine.force[i]), sum += fine.force[i];
  figures.push_back(most_figure("nodule, superposed: mean difference of the force", "the fine mesh",
                                "relative", difference / sum, 0.03));
  figures.push_back(near_figure("nodule, superposed: contrast", "the fine mesh",
                                find_peak(nodule, superposed).contrast, find_peak(nodule, fine).contrast,
                                0.10));
  return figures;
}

std::vector<Figure> validate_sfem(const Exec& exec, bool quick, const fs::path& folder,
                                  ordered_json& report) {
  const auto plate = required(validate_plate(exec));
  report["plate"] = report_plate(plate);
  const HertzResult hertz = required(validate_hertz(exec));
  report["hertz"] = report_hertz(hertz, folder);
  std::vector<LayerRow> layer;
  {
    ProgressBar bar("layers, 1 of 4");
    layer = required(validate_layer(exec, quick, bar.callback()));
  }
  report["layer"] = report_of(layer);
  std::vector<ElementsRow> elements;
  {
    ProgressBar bar("elements on organs, 2 of 4");
    elements = required(validate_elements(exec, quick, bar.callback()));
  }
  report["elements"] = report_of(elements);
  std::vector<RefinementRow> refinement;
  {
    ProgressBar bar("refinement, 3 of 4");
    refinement = required(validate_refinement(exec, !quick, bar.callback()));
  }
  report["refinement"] = report_refinement(refinement, folder);
  NoduleResult nodule;
  {
    ProgressBar bar("nodule, 4 of 4");
    nodule = required(validate_nodule(exec, quick ? 9 : 17, quick ? 0.05 : 0.08, bar.callback()));
  }
  report["nodule"] = report_nodule(nodule, folder);
  std::vector<Figure> figures = sfem_figures(plate, hertz, refinement, nodule);
  for (const auto& more : {figures_of(layer), figures_of(elements)})
    figures.insert(figures.end(), more.begin(), more.end());
  return figures;
}

/// A validation and its cost.
struct Validation {
  const char* model;
  const char* about;
  const char* quick_cost;
  const char* cost;
};
constexpr Validation kValidations[] = {
    {"lattice", "Validate bars, weight, skin tension, gaping slits and wounds",
     "a minute of one core, 0.1 GB", "three minutes of one core, 0.2 GB"},
    {"sfem", "Validate a plate, Hertz contact, a thin layer, element types, refinement, a nodule",
     "one minute of one core, 1 GB", "seven minutes of one core, 5 GB"},
    {"rhombus", "Validate presses and pulls of a half space and of finite elements, random grasps",
     "ten seconds of one core, 0.5 GB", "half a minute of one core, 1 GB"},
    {"cloth", "Validate catenary, period, fall, wind, folds, stretch, drape", "a second of one core, 0.1 GB",
     "some seconds of one core, 0.1 GB"},
    {"surgery",
     "Validate needles and sutures: puncture, toughness, energy, rest, a shaft; closing forces, running "
     "threads",
     "20 seconds of one core, 0.3 GB", "40 seconds of one core, 0.3 GB"},
    {"measured", "Compare with measured muscle, skin, brain, silicone and strips under their weight",
     "ten seconds of one core, 0.1 GB", "80 seconds of one core, 0.1 GB"}};
/// The models, whose figures are expected within their bounds. Measured tissue has known misses.
constexpr std::span<const Validation> kModels{kValidations, std::size(kValidations) - 1};

std::vector<Figure> figures_of(const Exec& exec, const std::string& model, bool quick, const fs::path& folder,
                               ordered_json& report) {
  if (model == "lattice") return validate_lattice(exec, quick);
  if (model == "rhombus") return validate_rhombus(exec, quick);
  if (model == "cloth") return validate_cloth(exec, quick);
  if (model == "surgery") return validate_surgery(exec, quick, folder);
  if (model == "measured") return validate_measured(exec, quick, folder, report);
  return validate_sfem(exec, quick, folder, report);
}

/// Runs one validation and writes its folder; returns the names of figures beyond their bounds.
std::vector<std::string> validate(const Exec& exec, const Validation& validation, const fs::path& out,
                                  const ValidateOptions& options) {
  print_plain("validate {}: {}\n", validation.model, options.quick ? validation.quick_cost : validation.cost);
  std::fflush(stdout);
  OutputFolder folder = open_result_folder(out, options.force);
  ordered_json report{{"program", "turgor"},
                      {"version", program_version()},
                      {"validate", validation.model},
                      {"quick", options.quick}};
  const std::vector<Figure> figures =
      figures_of(exec, validation.model, options.quick, folder.path(), report);
  std::vector<std::string> missed = missed_names(figures);
  report["figures"] = to_json(figures);
  report["missed"] = missed;
  if (!report.contains("rows")) print_figures(figures);  // measured values have a table of their own
  required(write_file(folder.path() / kReportFile, json_text(report) + "\n"));
  commit_results(folder);
  print_plain("{} figures, {} beyond their bounds   {}\n\n", figures.size(), missed.size(),
              folder.goal().string());
  return missed;
}

void validate_all(const Exec& exec, std::span<const Validation> validations, const ValidateOptions& options) {
  std::vector<std::string> missed;
  for (const Validation& v : validations) {
    const std::string name = std::string("validate-") + v.model;
    const fs::path out = options.out.empty()       ? fs::path("out") / name
                         : validations.size() == 1 ? options.out
                                                   : options.out / name;
    for (const std::string& one : validate(exec, v, out, options))
      missed.push_back(std::string(v.model) + ": " + one);
  }
  if (!missed.empty())
    throw Failure{kMissed, fmt::format("beyond their bounds: {}", fmt::join(missed, "; "))};
}

void add_validation(CLI::App& validate, Global& global, const std::string& name, const std::string& about,
                    std::span<const Validation> validations) {
  CLI::App* command = validate.add_subcommand(name, about);
  auto options = std::make_shared<ValidateOptions>();
  command->add_option("-o,--out", options->out,
                      "Folder for curves, maps and numbers (default: out/validate-…)");
  command->add_flag("--quick", options->quick,
                    "Coarser meshes, fewer points: two minutes at most for each model");
  add_force_option(*command, options->force);
  command->footer("Example:\n  turgor validate " + name + " --quick");
  command->callback(
      [options, validations, &global] { validate_all(Exec(global.threads), validations, *options); });
}

}  // namespace

void add_validate_command(CLI::App& program, Global& global) {
  CLI::App* validate = program.add_subcommand(kValidate.command, kValidate.about);
  validate->require_subcommand(1);
  for (const Validation& v : kValidations) add_validation(*validate, global, v.model, v.about, {&v, 1});
  add_validation(*validate, global, "all", "Validate all models, without the comparison with measured tissue",
                 kModels);
  validate->footer(
      "Example:\n  turgor validate sfem --out out/validation\nExit code 3: a figure is beyond its bound.");
}

}  // namespace turgor
