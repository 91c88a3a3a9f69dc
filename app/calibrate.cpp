// turgor calibrate: fits the rhombus chain to a force–depth curve, measured (a .csv) or felt by the tool of a
// scene, and shows both curves and what is left between them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/io/file.hpp"
#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/tools/force_curve.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using rhombus::CurvePoint;

constexpr double kAccepted = 0.05;        // largest residual, of the peak force
constexpr std::size_t kMostPoints = 200;  // of a curve felt in a scene

struct CalibrateOptions {
  fs::path input, out;
  std::vector<std::string> overrides;
  double side = 5;  // [mm]
  bool force = false;
};

template <class T>
T required(Result<T> result) {
  if (!result) throw Failure{2, result.error().message};
  return std::move(*result);
}

/// What the scene's first tool felt while it went in.
std::vector<CurvePoint> felt_curve(const World& world, const fs::path& scene) {
  const TouchLog& samples = world.tools[0].samples;
  const auto deepest =
      std::max_element(samples.begin(), samples.end(), [](auto& a, auto& b) { return a.depth < b.depth; });
  std::vector<CurvePoint> curve{{0, 0}};
  for (auto s = samples.begin(); s != samples.end() && s <= deepest; ++s)
    if (s->depth > curve.back().depth) curve.push_back({s->depth, norm(s->force)});
  if (curve.size() < 5)
    throw Failure{2, fmt::format("{}: the tool {} hardly touches: expected a press, found {} moments of it",
                                 scene.string(), world.tools[0].name, curve.size() - 1)};
  const std::size_t stride = (curve.size() + kMostPoints - 1) / kMostPoints;
  std::vector<CurvePoint> thinned;
  for (std::size_t i = 0; i < curve.size(); i += stride) thinned.push_back(curve[i]);
  return thinned;
}

std::vector<CurvePoint> curve_of_scene(const Exec& exec, const CalibrateOptions& options) {
  const Scene scene = required(read_scene(options.input, options.overrides));
  if (scene.tools.empty())
    throw Failure{2,
                  fmt::format("{}: expected a tool that presses a body with model = \"sfem\", found no tool",
                              options.input.string())};
  World world = required(load_world(exec, scene));
  ProgressBar bar("pressing");
  const int frames = frame_count(scene);
  for (int frame = 0; frame < frames; frame++) {
    if (!required(step(exec, world)).finite)
      throw Failure{kNotFinite, fmt::format("{}: the numbers of the press were not finite after {:.3f} s",
                                            options.input.string(), time_of(world))};
    bar.update(double(frame + 1) / frames);
  }
  return felt_curve(world, options.input);
}

void write_plot(const Plot& plot, const fs::path& file) { required(write_file(file, plot_svg_file(plot))); }

/// The curves, as a table and as pictures.
void write_curves(const std::vector<CurvePoint>& curve, const rhombus::Fit& fit, const fs::path& folder) {
  const rhombus::Chain chain = required(rhombus::build_chain(fit.params));
  Plot forces{"Force over depth", "depth [mm]", "force [N]", {{"given", {}}, {"rhombus chain", {}}}, false};
  Plot residual{"What is left", "depth [mm]", "chain - given [N]", {{"residual", {}}}, false};
  std::string table = "depth_m,force_N,chain_N\n";
  for (const CurvePoint& p : curve) {
    const double found = rhombus::force_of_depth(chain, p.depth);
    forces.curves[0].points.emplace_back(1e3 * p.depth, p.force);
    forces.curves[1].points.emplace_back(1e3 * p.depth, found);
    residual.curves[0].points.emplace_back(1e3 * p.depth, found - p.force);
    table += fmt::format("{:.9g},{:.9g},{:.9g}\n", p.depth, p.force, found);
  }
  write_plot(forces, folder / "force.svg");
  write_plot(residual, folder / "residual.svg");
  required(write_file(folder / "curve.csv", table));
}

Json to_json(const CalibrateOptions& options, const std::vector<CurvePoint>& curve, const rhombus::Fit& fit) {
  const rhombus::ChainParams& p = fit.params;
  return {{"program", "turgor"},
          {"version", program_version()},
          {"input", options.input.string()},
          {"points", curve.size()},
          {"normal_N_per_m", p.normal},
          {"tangential_N_per_m", p.tangential},
          {"decay", p.decay},
          {"angle_deg", p.angle * 180 / std::numbers::pi},
          {"side_mm", p.side * 1e3},
          {"residual_rms", fit.rms},
          {"residual_largest", fit.largest},
          {"accepted", fit.largest <= kAccepted}};
}

void print(const rhombus::Fit& fit, const fs::path& out) {
  const rhombus::ChainParams& p = fit.params;
  fmt::print(
      "k_N {:.5g} N/m, k_T1 {:.5g} N/m, beta {:.4g}, theta {:.4g} degrees, side {:.4g} mm\n"
      "largest residual {:.2f} % of the peak force, root mean square {:.2f} % ({})\n\n"
      "In a scene:\n  chain = {{ normal = {:.6g}, tangential = {:.6g}, decay = {:.6g}, angle = {:.6g}, side "
      "= "
      "{:.6g} }}\n\nboth curves and the residual   {}\n",
      p.normal, p.tangential, p.decay, p.angle * 180 / std::numbers::pi, p.side * 1e3, 100 * fit.largest,
      100 * fit.rms, fit.largest <= kAccepted ? "within 5 %" : "more than 5 %: another side may fit better",
      p.normal, p.tangential, p.decay, p.angle * 180 / std::numbers::pi, p.side, out.string());
}

void calibrate(const Exec& exec, const CalibrateOptions& options) {
  OutputFolder folder = open_result_folder(
      options.out.empty() ? fs::path("out") / options.input.stem() : options.out, options.force);
  const bool measured = options.input.extension() != ".toml";
  const std::vector<CurvePoint> curve =
      measured ? required(read_force_curve(options.input)) : curve_of_scene(exec, options);
  rhombus::ChainParams start;
  start.side = options.side * 1e-3;
  Result<rhombus::Fit> fit = rhombus::calibrate(curve, start);
  if (!fit) throw Failure{2, options.input.string() + ": " + fit.error().message};
  write_curves(curve, *fit, folder.path());
  required(write_file(folder.path() / kReportFile, json_text(to_json(options, curve, *fit)) + "\n"));
  commit_results(folder);
  print(*fit, folder.goal());
}

}  // namespace

void add_calibrate_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = program.add_subcommand("calibrate", "Fit the rhombus chain to a force-depth curve");
  command
      ->add_option("input", options->input,
                   "A .csv of depth [m] and force [N], or a scene whose tool presses an sfem body")
      ->required();
  command->add_option("--side", options->side, "Side of the rhombi [mm]; the dent is some of them wide")
      ->check(number_within(0.01, 1000, "mm"));
  command->add_option("-o,--out", options->out, "Folder for the curves (default: out/INPUT)");
  add_force_option(*command, options->force);
  command->add_option("--set", options->overrides, "key=value: overrides a key of the scene; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
  command->footer(
      "Examples:\n  turgor calibrate scenes/calibrate-liver.toml\n  turgor calibrate measured.csv --side 4");
  command->callback([options, &global] { calibrate(Exec(global.threads), *options); });
}

}  // namespace turgor
