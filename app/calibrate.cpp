// `turgor calibrate`: fits the rhombus chain to a force–depth curve, either measured (a .csv) or simulated in
// a scene. In a scene, the curve is the force on a tool that presses a body of the sfem model. Pulls of the
// same half space are added. Writes both curves and the residual.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/print.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"
#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/tools/force_curve.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using rhombus::CurvePoint;

constexpr double kAccepted = 0.10;  // largest accepted residual, relative to the force at that depth [1]
constexpr std::size_t kMostPoints = 200;  // of a curve simulated in a scene

struct CalibrateOptions {
  fs::path input, out;
  std::vector<std::string> overrides;
  double side = 0;            // [mm]; 0 = chosen by the radius of the tip
  std::optional<double> tip;  // radius of the tip of a measured curve [mm]; default: 5
  double stiffening = 1;      // of a pulled unit
  bool force = false;
};

/// Data that a chain is fitted to.
struct Given {
  std::vector<CurvePoint> curve;
  double tip = 0;        // radius of the pressing ball [m]
  double stiffness = 1;  // of the body at the press, relative to a half space; the curve is divided by it [1]
  std::string units;     // by which a table was read, "mm, N"; empty: a scene
};

/// Force–depth curve of the scene's first tool while it moves in.
std::vector<CurvePoint> force_curve(const World& world, const fs::path& scene) {
  const TouchLog& samples = world.tools[0].samples;
  const auto deepest =
      std::max_element(samples.begin(), samples.end(), [](auto& a, auto& b) { return a.depth < b.depth; });
  std::vector<CurvePoint> curve{{0, 0}};
  for (auto s = samples.begin(); s != samples.end() && s <= deepest; ++s)
    if (s->depth > curve.back().depth) curve.push_back({s->depth, norm(s->force)});
  if (curve.size() < 5)
    throw Failure{
        2,
        fmt::format("{}: the tool {} hardly touches the body: expected a press, found {} samples of contact",
                    scene.string(), world.tools[0].name, curve.size() - 1)};
  const std::size_t stride = (curve.size() + kMostPoints - 1) / kMostPoints;
  std::vector<CurvePoint> thinned;
  for (std::size_t i = 0; i < curve.size(); i += stride) thinned.push_back(curve[i]);
  return thinned;
}

/// Stiffness of the body where its first tool is deepest, relative to a half space [1].
double stiffness_at_press(const Exec& exec, const World& world, double tip, const fs::path& scene) {
  const TouchingTool& tool = world.tools[0];
  const SfemBody& body = world.sfem_bodies[0];
  const SolidBoundary outer = solid_boundary(body.model);
  const rhombus::Model surface = required(rhombus::build(outer.body, {}));
  const std::vector<double> stiffness = required(
      elastic_stiffness(exec, body.model, outer, surface.surface, usual_contact(tip)), scene.string() + ": ");
  const auto deepest = std::max_element(tool.samples.begin(), tool.samples.end(),
                                        [](auto& a, auto& b) { return a.depth < b.depth; });
  const rhombus::FootPoint foot = rhombus::find_foot_point(surface.surface, surface.tree, deepest->position);
  rhombus::Model scaled = surface;
  scaled.stiffness = stiffness;
  return rhombus::stiffness_at(scaled, foot.at);
}

/// Adds pulls by a disc of the tip's radius that holds the surface, up to a strain of 30 % below it. Presses
/// are divided by the stiffness of the body at their point, so pulls are those of a half space.
void add_pull(Given& given, double modulus) {
  for (int i = 1; i <= 15; i++) {
    const double pull = rhombus::kPulledRadii * given.tip * i / 15;
    given.curve.push_back({-pull, -rhombus::disc_stiffness(modulus, given.tip) * pull});
  }
}

Given curve_of_scene(const Exec& exec, const CalibrateOptions& options) {
  const Scene scene = required(read_scene(options.input, options.overrides));
  if (scene.tools.empty() || scene.tools[0].body.kind != BodyKind::kSfem)
    throw Failure{2, fmt::format("{}: expected a tool that presses a body with model = \"sfem\", found {}",
                                 options.input.string(), scene.tools.empty() ? "no tool" : "another body")};
  World world = required(load_world(exec, scene));
  ProgressBar bar("pressing");
  const int frames = frame_count(scene);
  for (int frame = 0; frame < frames; frame++) {
    if (!required(step(exec, world)).finite)
      throw Failure{kNotFinite, fmt::format("{}: the press was not finite after {:.3f} s",
                                            options.input.string(), time_of(world))};
    bar.update(double(frame + 1) / frames);
  }
  const TouchingTool& tool = world.tools[0];
  const double tip = contact::rhombus_tip(tool.tool.shape, tool.forceps).radius;
  Given given{force_curve(world, options.input), tip, stiffness_at_press(exec, world, tip, options.input),
              ""};
  for (CurvePoint& p : given.curve) p.force /= given.stiffness;
  const sfem::Material& material = world.sfem_bodies[0].model.body.materials[0];
  add_pull(given, rhombus::contact_modulus(material.young, material.poisson));
  return given;
}

void write_plot(const Plot& plot, const fs::path& file) { required(write_file(file, plot_svg_file(plot))); }

/// Writes the curves as a table and as plots.
void write_curves(const std::vector<CurvePoint>& curve, const rhombus::Fit& fit, const fs::path& folder) {
  const rhombus::Chain chain = required(rhombus::build_chain(fit.params));
  const rhombus::Tip tip = rhombus::tip_on(chain, fit.params.tip);
  Plot forces{"Force over depth", "depth [mm]", "force [N]", {{"given", {}}, {"rhombus chain", {}}}, false};
  Plot residual{"Residual", "depth [mm]", "chain - given [N]", {{"residual", {}}}, false};
  std::string table = "depth_m,force_N,chain_N\n";
  for (const CurvePoint& p : curve) {
    const double found = rhombus::force_of_tip(chain, tip, p.depth);
    forces.curves[0].points.emplace_back(1e3 * p.depth, p.force);
    forces.curves[1].points.emplace_back(1e3 * p.depth, found);
    residual.curves[0].points.emplace_back(1e3 * p.depth, found - p.force);
    table += fmt::format("{:.9g},{:.9g},{:.9g}\n", p.depth, p.force, found);
  }
  write_plot(forces, folder / "force.svg");
  write_plot(residual, folder / "residual.svg");
  required(write_file(folder / "curve.csv", table));
}

Json to_json(const CalibrateOptions& options, const Given& given, const rhombus::Fit& fit) {
  const rhombus::ChainParams& p = fit.params;
  return {{"program", "turgor"},
          {"version", program_version()},
          {"input", options.input.string()},
          {"units", given.units},
          {"points", given.curve.size()},
          {"relative_stiffness", given.stiffness},
          {"normal_N_per_m", p.normal},
          {"tangential_N_per_m", p.tangential},
          {"decay", p.decay},
          {"angle_deg", p.angle * 180 / std::numbers::pi},
          {"side_mm", p.side * 1e3},
          {"stiffening", p.stiffening},
          {"tip_mm", p.tip * 1e3},
          {"residual_rms", fit.rms},
          {"residual_largest", fit.largest},
          {"accepted", fit.largest <= kAccepted}};
}

/// "3.2 %"; far beyond any fit, a bound.
std::string percent_text(double error) {
  constexpr double kMost = 10;
  return error > kMost ? fmt::format("more than {:.0f} %", 100 * kMost)
                       : fmt::format("{:.1f} %", 100 * error);
}

void print(const fs::path& input, const Given& given, const rhombus::Fit& fit, const fs::path& out) {
  const rhombus::ChainParams& p = fit.params;
  const double degrees = p.angle * 180 / std::numbers::pi;
  if (!given.units.empty()) print_plain("{} read as {}\n", input.string(), given.units);
  if (given.stiffness != 1)
    print_plain(
        "the body is {:.3g} times as stiff as a half space at this point: forces are divided by that, "
        "use the chain with stiffness = {{ body = ... }}\n",
        given.stiffness);
  print_plain(
      "k_N {:.5g} N/m, k_T1 {:.5g} N/m, beta {:.4g}, theta {:.4g} degrees, side {:.4g} mm, for a tip of "
      "{:.4g} mm\n"
      "residual relative to the force: largest {}, root mean square {} ({})\n\n"
      "In a scene:\n  chain = {{ normal = {:.6g}, tangential = {:.6g}, decay = {:.6g}, angle = {:.6g}, "
      "side = {:.6g}, stiffening = {:.6g}, tip = {:.6g} }}\n\nboth curves and the residual   {}\n",
      p.normal, p.tangential, p.decay, degrees, p.side * 1e3, p.tip * 1e3, percent_text(fit.largest),
      percent_text(fit.rms),
      fit.largest <= kAccepted ? "within 10 %" : "more than 10 %: another side may fit better", p.normal,
      p.tangential, p.decay, degrees, p.side, p.stiffening, p.tip, out.string());
}

rhombus::ChainParams start_of_fit(const CalibrateOptions& options, double tip) {
  constexpr double kSides = 1.25;  // in radii of the tip; fits presses and pulls of a half space best
  rhombus::ChainParams start;
  start.tip = tip, start.stiffening = options.stiffening;
  start.side = options.side > 0 ? options.side * 1e-3 : tip > 0 ? kSides * tip : start.side;
  return start;
}

void calibrate(const Exec& exec, const CalibrateOptions& options) {
  const bool measured = options.input.extension() != ".toml";
  if (measured && !options.overrides.empty())
    throw Failure{2, options.input.string() + ": --set changes scenes; this is a table"};
  if (!measured && options.tip)
    throw Failure{2, options.input.string() + ": --tip belongs to a table; the scene has its own tool"};
  OutputFolder folder = open_result_folder(
      options.out.empty() ? fs::path("out") / options.input.stem() : options.out, options.force);
  const Given given = measured
                          ? Given{required(read_force_curve(options.input)), options.tip.value_or(5) * 1e-3,
                                  1, required(force_curve_units(options.input))}
                          : curve_of_scene(exec, options);
  const rhombus::Fit fit = required(rhombus::calibrate(given.curve, start_of_fit(options, given.tip)),
                                    options.input.string() + ": ");
  write_curves(given.curve, fit, folder.path());
  required(write_file(folder.path() / kReportFile, json_text(to_json(options, given, fit)) + "\n"));
  commit_results(folder);
  print(options.input, given, fit, folder.goal());
}

}  // namespace

void add_calibrate_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = program.add_subcommand("calibrate", "Fit the rhombus chain to a force-depth curve");
  command
      ->add_option("input", options->input,
                   "A .csv of depth [m] and force [N], or with units in its header such as depth_mm,force_N; "
                   "pulls have negative depth and force. Or a scene whose tool presses an "
                   "sfem body")
      ->required();
  command
      ->add_option("--side", options->side,
                   "Side of the rhombi [mm]; a dent spans several rhombi (default: 1.25 radii of the tip)")
      ->check(number_within(0.01, 1000, "mm"));
  command
      ->add_option("--tip", options->tip,
                   "Radius of the pressing ball of a .csv [mm]; 0: a chain without a tip (default: 5)")
      ->check(number_within(0, 1000, "mm"));
  command
      ->add_option("--stiffening", options->stiffening,
                   "Largest exponent by which a unit stiffens when pulled by its own height (default: 1)")
      ->check(number_within(0.01, 100, "1"));
  command->add_option("-o,--out", options->out, "Folder for the curves (default: out/INPUT)");
  add_force_option(*command, options->force);
  add_set_option(*command, options->overrides);
  command->footer(
      "Examples:\n  turgor calibrate scenes/calibrate-liver.toml\n  turgor calibrate measured.csv --side 4");
  command->callback([options, &global] { calibrate(Exec(global.threads), *options); });
}

}  // namespace turgor
