// `turgor plan-excision`: simulates an excision and its closure in several directions and shapes, and
// compares the forces that close the wound. Writes a table, a page with a polar plot, and report.json.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/plan_page.hpp"
#include "app/print.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/replace_cuts.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/report_skin.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct PlanOptions {
  fs::path scene, out;
  std::string excision;
  std::vector<std::string> overrides;
  std::vector<double> ratios;  // of length to width; empty: the scene's lens
  double lesion = 0;           // diameter of the circle on the skin that is cut out [m]; 0: the scene's width
  int directions = 12;
  bool force = false;
};

/// The excision that is planned, and the suture that closes it.
struct Planned {
  std::size_t cut = 0, suture = 0;
  std::string name;
};
Planned find_planned(const Scene& scene, const PlanOptions& options) {
  const std::string where = options.scene.string() + ": ";
  std::vector<std::size_t> found;
  for (std::size_t c = 0; c < scene.incisions.size(); c++) {
    const lattice::Incision& blade = scene.incisions[c].blade;
    if (blade.excision && (options.excision.empty() || blade.name == options.excision)) found.push_back(c);
  }
  if (found.size() != 1)
    throw Failure{2, where + (options.excision.empty()
                                  ? fmt::format("expected one [excision.NAME], or --excision NAME; found {}",
                                                found.size())
                                  : fmt::format("the scene has no excision {}", options.excision))};
  Planned planned{.cut = found[0], .name = scene.incisions[found[0]].blade.name};
  const auto suture = std::find_if(scene.sutures.begin(), scene.sutures.end(),
                                   [&](const SutureScene& s) { return s.incision == int(planned.cut); });
  if (suture == scene.sutures.end())
    throw Failure{
        2, where + fmt::format("no suture closes the excision {0}: expected [suture.NAME] with wound = "
                               "\"{0}\"",
                               planned.name)};
  planned.suture = std::size_t(suture - scene.sutures.begin());
  return planned;
}

constexpr double kClosedGape = 3e-4;  // [m]

/// Bodies at rest, loaded once for all directions.
struct PlanWorld {
  World world;
  std::vector<LatticeBody> at_rest;

  PlanWorld(const Exec& exec, const Scene& scene, const fs::path& file)
      : world(required(load_world(exec, scene))), at_rest(world.lattice_bodies) {
    const auto device = std::any_of(scene.lattice_bodies.begin(), scene.lattice_bodies.end(),
                                    [](const LatticeScene& body) { return body.device == Device::kGpu; });
    if (device || !world.tools.empty() || !world.sfem_bodies.empty() || !world.rhombus_bodies.empty() ||
        !world.cloth_bodies.empty() || !world.rigid_bodies.empty() || !is_empty(world.coupling))
      throw Failure{2, file.string() +
                           ": a plan simulates lattice bodies on the CPU: expected no tools, no "
                           "other bodies, and no attachments or contacts"};
  }
  /// The world at rest with the cuts of another scene.
  World& with_cuts_of(const Scene& scene) {
    world.lattice_bodies = at_rest, world.frame = 0;
    const Status replaced = replace_cuts(scene, world);
    if (!replaced) throw Failure{2, replaced.error().message};
    return world;
  }
};

/// True if the stitches of a suture are pulled, and nothing moves any more.
bool is_at_rest(const Suture& suture) {
  if (!suture.closure || !suture.closure->settled) return false;
  return std::all_of(suture.closure->stitches.begin(), suture.closure->stitches.end(),
                     [](const lattice::Stitch& stitch) {
                       return stitch.phase != lattice::StitchPhase::kWaiting &&
                              stitch.phase != lattice::StitchPhase::kPulled;
                     });
}

/// Lenses to compare. The width of a lens is the diameter of the circle that fits into it.
std::vector<lattice::Excision> lenses_of(const lattice::Excision& drawn, const PlanOptions& options) {
  std::vector<double> ratios = options.ratios;
  if (ratios.empty()) ratios.push_back(drawn.length / drawn.width);
  std::vector<lattice::Excision> shapes;
  for (const double ratio : ratios) {
    lattice::Excision& shape = shapes.emplace_back(drawn);
    if (options.lesion > 0) shape.width = options.lesion;
    if (options.lesion > 0 || !options.ratios.empty()) shape.length = ratio * shape.width;
  }
  return shapes;
}

/// Simulates one shape in one direction until the stitches are at rest, at most kLongest times the duration
/// of the scene.
PlannedExcision simulate_excision(const Exec& exec, const PlanOptions& options,
                                  const lattice::Excision& shape, double angle, const Scene& drawn,
                                  PlanWorld& loaded, const Progress& progress) {
  constexpr double kLongest = 4;
  constexpr int kRestFrames = 15;
  Scene scene = drawn;
  const Planned planned = find_planned(scene, options);
  lattice::Excision& piece = *scene.incisions[planned.cut].blade.excision;
  piece = shape;
  piece.angle = std::remainder(piece.angle + angle, 360);
  scene.duration *= kLongest;
  World& world = loaded.with_cuts_of(scene);
  int rest = 0;
  const auto goes_on = [&](const World& now) {
    rest = is_at_rest(now.sutures[planned.suture]) ? rest + 1 : 0;
    return rest < kRestFrames;
  };
  // a piece that does not come off in one direction leaves the others
  const Result<Simulated> simulated = simulate(exec, scene, world, {.progress = progress, .frame = goes_on});
  PlannedExcision found{.length = shape.length, .width = shape.width, .angle = angle};
  if (!simulated) {
    found.problem = simulated.error().message;
    return found;
  }
  const Simulated& run = *simulated;
  if (!run.finite)
    throw Failure{kNotFinite, fmt::format("{}: the run at {:.0f} degrees was not finite after {:.3f} s",
                                          options.scene.string(), angle, time_of(world))};
  const CutMeasures& wound = run.measures.cuts[planned.cut];
  const SutureMeasures& suture = run.measures.sutures[planned.suture];
  if (!suture.series.empty()) {
    const SutureSample& last = suture.series.back();
    found.closing_force = last.closing_force, found.tension_max = last.tension_max;
    found.gape = last.gape_max, found.lost = last.pulled_out + last.broken;
    found.is_closed = rest >= kRestFrames && last.gape_max <= kClosedGape && found.lost == 0;
  }
  found.angle_to_lines = wound.tension.angle, found.is_directional = wound.tension.is_directional;
  if (wound.dog_ears) found.dog_ear = std::max(wound.dog_ears->first, wound.dog_ears->last);
  if (const auto stretch = largest_skin_stretch(exec, world, scene.sutures[planned.suture].body))
    found.stretch = stretch->largest;
  if (wound.specimen) found.shrinkage = 1 - wound.specimen->free.length / wound.specimen->in_place.length;
  return found;
}

Json to_json(const PlanOptions& options, const std::string& name, const std::vector<PlannedExcision>& found,
             const PlanVerdict& verdict) {
  Json directions = Json::array();
  for (const PlannedExcision& d : found)
    if (!d.problem.empty())
      directions.push_back({{"length_mm", rounded(1e3 * d.length)},
                            {"width_mm", rounded(1e3 * d.width)},
                            {"angle_deg", rounded(d.angle)},
                            {"problem", d.problem}});
    else
      directions.push_back(
          {{"length_mm", rounded(1e3 * d.length)},
           {"width_mm", rounded(1e3 * d.width)},
           {"angle_deg", rounded(d.angle)},
           {"angle_to_lines_deg", d.is_directional ? Json(rounded(d.angle_to_lines)) : Json()},
           {"closing_force_N", rounded(d.closing_force)},
           {"tension_max_N", rounded(d.tension_max)},
           {"gape_max_mm", rounded(1e3 * d.gape)},
           {"dog_ear_mm", rounded(1e3 * d.dog_ear)},
           {"largest_stretch", rounded(d.stretch)},
           {"specimen_shrinkage_percent", rounded(100 * d.shrinkage)},
           {"closed", d.is_closed},
           {"stitches_lost", d.lost}});
  return {{"program", "turgor"},
          {"version", program_version()},
          {"scene", options.scene.string()},
          {"excision", name},
          {"directions", directions},
          {"best_angle_deg", verdict.has_closed ? Json(rounded(found[verdict.best].angle)) : Json()},
          {"best_ratio", verdict.has_closed ? Json(rounded(found[verdict.best].ratio())) : Json()},
          {"worst_angle_deg", verdict.has_closed ? Json(rounded(found[verdict.worst].angle)) : Json()},
          {"worst_over_best", verdict.has_closed ? Json(rounded(verdict.ratio)) : Json()},
          {"verdict", verdict.sentence}};
}

void print(const std::vector<PlannedExcision>& found, const PlanVerdict& verdict, const fs::path& out) {
  print_plain("{}", "");
  fmt::print("{:>5}  {:>9}  {:>13}  {:>14}  {:>8}  {:>7}  {:>7}\n", "ratio", "direction", "closing force",
             "largest thread", "gape", "dog ear", "stretch");
  for (std::size_t n = 0; n < found.size(); n++) {
    const PlannedExcision& d = found[n];
    fmt::print("{:>5.3g}  {:>7.0f} °  ", d.ratio(), d.angle);
    if (!d.problem.empty()) {
      print_plain("{}\n", d.problem);
      continue;
    }
    fmt::print("{:>11.3f} N  {:>12.3f} N  {:>5.2f} mm  {:>4.1f} mm  {:>7.3f}{}{}\n", d.closing_force,
               d.tension_max, 1e3 * d.gape, 1e3 * d.dog_ear, d.stretch,
               !verdict.has_closed  ? ""
               : n == verdict.best  ? "  best"
               : n == verdict.worst ? "  worst"
                                    : "",
               d.is_closed ? "" : "  open");
  }
  print_plain("\n{}\n\ntable, polar plot and page   {}\n", verdict.sentence, out.string());
}

void plan_excision(const Exec& exec, const PlanOptions& options) {
  const Scene scene = required(read_scene(options.scene, options.overrides));
  const Planned planned = find_planned(scene, options);
  const std::vector<lattice::Excision> shapes =
      lenses_of(*scene.incisions[planned.cut].blade.excision, options);
  OutputFolder folder = open_result_folder(
      options.out.empty() ? fs::path("out") / (options.scene.stem().string() + "-plan") : options.out,
      options.force);
  PlanWorld loaded(exec, scene, options.scene);
  // one run per shape and direction; a lens has the same shape after half a turn
  std::vector<PlannedExcision> found;
  {
    ProgressBar bar("planning");
    const double runs = double(shapes.size()) * options.directions;
    for (const lattice::Excision& shape : shapes)
      for (int n = 0; n < options.directions; n++) {
        const double done = double(found.size());
        found.push_back(simulate_excision(exec, options, shape, 180.0 * n / options.directions, scene, loaded,
                                          [&](double fraction) { bar.update((done + fraction) / runs); }));
      }
  }
  // results
  if (std::all_of(found.begin(), found.end(), [](const PlannedExcision& d) { return !d.problem.empty(); }))
    throw Failure{2, fmt::format("{}: {}", options.scene.string(), found[0].problem)};
  const PlanVerdict verdict = verdict_of(found);
  std::string table =
      "length_mm,width_mm,angle_deg,closing_force_N,tension_max_N,gape_max_mm,dog_ear_mm,largest_stretch,"
      "specimen_shrinkage_percent\n";
  for (const PlannedExcision& d : found)
    if (d.problem.empty())
      table += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", 1e3 * d.length,
                           1e3 * d.width, d.angle, d.closing_force, d.tension_max, 1e3 * d.gape,
                           1e3 * d.dog_ear, d.stretch, 100 * d.shrinkage);
  required(write_file(folder.path() / "plan.csv", table));
  required(write_file(folder.path() / "closing-force.svg", polar_svg(found, verdict)));
  required(write_file(folder.path() / "plan.html", plan_page(planned.name, found, verdict)));
  required(write_file(folder.path() / kReportFile,
                      json_text(to_json(options, planned.name, found, verdict)) + "\n"));
  commit_results(folder);
  print(found, verdict, folder.goal());
}

}  // namespace

void add_plan_excision_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* command = program.add_subcommand(
      "plan-excision", "Compare the closing force of an excision over its direction and shape");
  command
      ->add_option("scene", options->scene,
                   "A scene with an [excision.NAME] and a [suture.NAME] that closes it")
      ->required();
  command->add_option("--excision", options->excision, "The excision to plan, if the scene has several");
  command
      ->add_option("--directions", options->directions,
                   "Directions over half a turn, counter-clockwise seen from outside (default: 12)")
      ->check(CLI::Range(2, 180));
  command
      ->add_option("--ratios", options->ratios,
                   "Ratios of length to width to compare, for example 2,3,4 (default: that of the scene)")
      ->delimiter(',')
      ->check(number_within(1, 10, "1"));
  command
      ->add_option("--lesion", options->lesion,
                   "Diameter of the circle of skin that is cut out, in m: the width of the lens (default: "
                   "that of the scene)")
      ->check(number_within(1e-3, 0.5, "m"));
  command->add_option("-o,--out", options->out, "Folder for the results (default: out/SCENE-plan)");
  add_force_option(*command, options->force);
  add_set_option(*command, options->overrides);
  command->footer(
      "Examples:\n  turgor plan-excision scenes/excision.toml --set excision.mole.length=0.05\n"
      "  turgor plan-excision scenes/excision.toml --lesion 0.018 --ratios 2.5,3,4 --directions 6");
  command->callback([options, &global] { plan_excision(Exec(global.threads), *options); });
}

}  // namespace turgor
