// A wound in a block of tense skin on tissue, by the lattice's step, the frame rate and the sweeps; and a
// ball on a layer of solid tissue, against the integral equation of such a layer.
#include "app/validate_wound.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "app/hayes.hpp"
#include "app/wound_elements.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/build/turned_block.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor {

namespace {

using lattice::Block;
using lattice::Model;
using lattice::Params;
using lattice::State;
using lattice::TissueLaw;

constexpr double kYoung = 5e3;
const char* name_of(TissueLaw law) { return law == TissueLaw::kSolid ? "solid" : "springs"; }

// ---------------------------------------------------------------- wounds

/// 96 × 96 × 24 mm, held at its sides and below, a cut of 36 mm in the middle of its skin, 10 mm deep.
constexpr double kSide = 0.096, kHeight = 0.024, kLength = 0.036, kDepth = 0.01;

/// Where the cut lies: its middle, from the lattice's node in the middle, and its direction. Langer's lines
/// go with it.
struct Place {
  double along = 0.5, across = 0.5;  // [steps]
  double degrees = 0;
  double size = 1;  // of the body and the cut
};

struct Wounded {
  Model model;
  State state;
  lattice::BladePath path;

  /// With a straight cut.
  Wounded(Model body, const lattice::Incision& blade) : model(std::move(body)), state(make_state(model)) {
    path = lay_blade(model, state, blade).value();
    cut_edges(model, state, path, 0, 1, 0);
  }

  double gape() const { return measure_wound(model, state, path, 0).gape_max; }
  void run(const Exec& exec, double seconds, double dt) {
    for (int n = 0; n < std::lround(seconds / dt); n++) lattice::step(exec, model, state, {}, dt);
  }
};

/// Langer's lines along the cut.
Params params_of(TissueLaw law, Vec3d line, const lattice::SolverParams& solver) {
  Params params;
  params.tissue.law = law;
  params.skin.direction = line;
  params.solver = solver;
  return params;
}

lattice::Incision cut_of(double step, const Place& place) {
  const int middle_node = (int(std::lround(place.size * kSide / step)) + 1) / 2;
  const double angle = place.degrees * std::numbers::pi / 180;
  const Vec3d middle{(middle_node + place.along) * step, (middle_node + place.across) * step,
                     place.size * kHeight};
  const Vec3d half = Vec3d{std::cos(angle), std::sin(angle), 0} * (0.5 * place.size * kLength);
  return {.from = middle - half, .to = middle + half, .depth = place.size * kDepth};
}
Wounded wounded_block(TissueLaw law, double step, const lattice::SolverParams& solver,
                      const Place& place = {}) {
  const int n = int(std::lround(place.size * kSide / step)) + 1,
            layers = int(std::lround(place.size * kHeight / step)) + 1;
  Block block{.size = {n, n, layers}, .step = step, .young = kYoung};
  block.is_fixed = [n](Int3 p) { return p.x == 0 || p.y == 0 || p.z == 0 || p.x == n - 1 || p.y == n - 1; };
  const lattice::Incision cut = cut_of(step, place);
  return {lattice::block_model(block, params_of(law, normalized(cut.to - cut.from), solver)), cut};
}

/// The same in a block that lies across the lattice.
Wounded turned_block(double step, const lattice::SolverParams& solver, const Mat3d& turn) {
  const Vec3d half = turn.column[0] * (0.5 * kLength), aside = turn.column[1] * (0.37 * step);
  return {turned_model({.side = kSide, .height = kHeight, .step = step, .young = kYoung, .turn = turn},
                       params_of(TissueLaw::kSolid, turn.column[0], solver)),
          {.from = aside - half, .to = aside + half, .depth = kDepth}};
}

double settled_gape(const Exec& exec, Wounded wounded, double rate) {
  wounded.run(exec, 4, 1 / rate);
  return wounded.gape();
}
double settled_gape(const Exec& exec, TissueLaw law, double step, double rate, int sweeps,
                    const Place& place = {}) {
  return settled_gape(exec, wounded_block(law, step, {.sweeps = sweeps, .damping = 4}, place), rate);
}

/// What elements that fit the blade say, on a line through two meshes to a mesh of no size.
double limit_of_elements(bool quick) {
  const lattice::SkinParams skin;
  const CutBlock block{.side = kSide,
                       .height = kHeight,
                       .length = kLength,
                       .depth = kDepth,
                       .young = kYoung,
                       .poisson = lattice::TissueParams{}.poisson,
                       .tension = skin.tension_along,
                       .stiffness = skin.stiffness,
                       .shear = skin.shear,
                       .amplification = skin.amplification};
  const int coarse = quick ? 4 : 6, fine = quick ? 6 : 8;
  const double a = gape_of_elements(block, coarse), b = gape_of_elements(block, fine);
  return b + (b - a) * coarse / (fine - coarse);
}

/// Gapes on finer and finer lattices, and of blades that lie otherwise in the cells. Springs, whose cells are
/// not parted but give way, are farther from the limit.
void add_steps(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  const double limit = limit_of_elements(quick);
  const auto add = [&](TissueLaw law, double step, const Place& place, double bound) {
    const bool other = place.degrees != 0 || place.across != 0.5;
    figures.push_back(near_figure(
        fmt::format("a wound in {}, step {:.1f} mm{}", name_of(law), 1e3 * step,
                    other ? fmt::format(", {:.1f} steps aside, {:.0f} degrees", place.across, place.degrees)
                          : std::string()),
        fmt::format("finite elements, {:.2f} mm", 1e3 * limit), settled_gape(exec, law, step, 30, 20, place),
        limit, bound));
  };
  std::vector<double> steps = {0.006, 0.004, 0.003};
  if (!quick) steps.insert(steps.end(), {0.002, 0.0015});
  for (const double step : steps) {
    add(TissueLaw::kSolid, step, {}, 0.05);
    add(TissueLaw::kSprings, step, {}, 0.08 * std::max(1.0, step / 0.004));
    figures.back().known_limit = step > 0.005;
  }
  for (const Place& place :
       {Place{0.25, 0.1, 0}, {0, 0.3, 90}, {0.5, 0.5, 30}, {0.5, 0.2, 110}, {0.5, 0.3, 45}})
    add(TissueLaw::kSolid, 0.004, place, 0.05);

  struct Turn {
    Vec3d axis;
    double degrees;
  };
  steps = quick ? std::vector{0.004} : std::vector{0.004, 0.003, 0.002};
  for (const double step : steps)
    for (const auto& [axis, degrees] :
         {Turn{{1, 0, 0}, 5}, {{1, 0, 0}, 15}, {{0, 1, 0}, 20}, {{1, 0.8, 0.1}, 33}, {{0.1, 1, 0.6}, 40}})
      figures.push_back(near_figure(
          fmt::format("a wound in solid, step {:.1f} mm, the body turned by {} degrees about "
                      "({}, {}, {})",
                      1e3 * step, degrees, axis.x, axis.y, axis.z),
          fmt::format("finite elements, {:.2f} mm", 1e3 * limit),
          settled_gape(
              exec, turned_block(step, {.sweeps = 20, .damping = 4}, lattice::turn_about(axis, degrees)), 30),
          limit, 0.15 * (step / 0.004) * (step / 0.004)));
}

void add_rates(const Exec& exec, TissueLaw law, bool quick, std::vector<Figure>& figures) {
  const double reference = settled_gape(exec, law, 0.004, 60, 20);
  std::vector<std::pair<double, int>> cases = {{30, 3}, {120, 5}};
  if (!quick) cases.insert(cases.end(), {{30, 20}, {60, 3}, {60, 5}, {120, 3}, {120, 20}});
  for (const auto& [rate, sweeps] : cases)
    figures.push_back(
        near_figure(fmt::format("a wound in {}, {:.0f} Hz, {} sweeps", name_of(law), rate, sweeps),
                    "60 Hz, 20 sweeps", settled_gape(exec, law, 0.004, rate, sweeps), reference, 0.01));
}

/// Gapes of a T: a cut, and half a second later one that comes up to it from below and ends on it.
std::array<double, 2> settled_t(const Exec& exec, const Place& place, double rate, int sweeps) {
  constexpr double kStep = 0.004;
  Wounded body = wounded_block(TissueLaw::kSolid, kStep, {.sweeps = sweeps, .damping = 4}, place);
  const lattice::Incision first = cut_of(kStep, place);
  const Vec3d meets = (first.from + first.to) * 0.5, line = normalized(first.to - first.from),
              up{-line.y, line.x, 0};
  body.run(exec, 0.5, 1 / rate);
  const lattice::LaidBlade laid{first, body.path};
  const lattice::Incision second{.from = meets - up * kLength, .to = meets, .depth = kDepth};
  const lattice::BladePath path = lay_blade(body.model, body.state, second, nullptr, {&laid, 1}).value();
  cut_edges(body.model, body.state, path, 0, 1, 1);
  body.run(exec, 3, 1 / rate);
  return {body.gape(), measure_wound(body.model, body.state, path, 1).gape_max};
}

/// Blades that cross: where the first wound is decides to a hair which way the second one takes.
void add_ts(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  std::vector<Place> places = {{.along = 0, .across = 0}};
  if (!quick)
    places.insert(places.end(),
                  {{.along = 0.3, .across = 0.2}, {.along = 0.1, .across = 0.4, .degrees = 30}});
  for (const Place& place : places) {
    const auto reference = settled_t(exec, place, 60, 20);
    for (const auto& [rate, sweeps] : {std::pair{60.0, 3}, {60.0, 5}, {30.0, 5}, {120.0, 5}}) {
      const auto found = settled_t(exec, place, rate, sweeps);
      for (const std::size_t cut : {std::size_t(0), std::size_t(1)})
        figures.push_back(near_figure(
            fmt::format(
                "the {} of a T, {:.1f} and {:.1f} steps beside nodes, {:.0f} degrees, {:.0f} Hz, {} sweeps",
                cut ? "stem" : "bar", place.along, place.across, place.degrees, rate, sweeps),
            "60 Hz, 20 sweeps", found[cut], reference[cut], 0.01));
    }
  }
}

/// On its way, not at rest: the farthest that the gape is from a converged way, of the gape at rest. What is
/// converged is left to sweeps alone.
Figure motion(const Exec& exec, TissueLaw law, double step, int sweeps, const Place& place) {
  constexpr double kFrame = 1.0 / 60, kDamping = 1.2;
  constexpr int kConverged = 200, kFrames = 40;
  Wounded few = wounded_block(law, step, {.sweeps = sweeps, .damping = kDamping}, place),
          many =
              wounded_block(law, step, {.sweeps = kConverged, .damping = kDamping, .coarse = false}, place);
  double farthest = 0;
  for (int n = 0; n < kFrames; n++) {
    few.run(exec, kFrame, kFrame), many.run(exec, kFrame, kFrame);
    farthest = std::max(farthest, std::abs(few.gape() - many.gape()));
  }
  std::string what = fmt::format("a wound in {} on its way, step {:.1f} mm, 60 Hz, {} sweeps", name_of(law),
                                 1e3 * step, sweeps);
  if (place.degrees != 0) what += fmt::format(", {:.0f} degrees", place.degrees);
  if (place.size != 1) what += fmt::format(", {:.0f} times the size", place.size);
  return most_figure(what, fmt::format("its way with {} sweeps alone", kConverged), "of the gape at rest",
                     farthest / many.gape(), law == TissueLaw::kSprings && sweeps > 5 ? 0.15 : 0.1);
}

void add_motion(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  const Place aslant{0.5, 0.3, 30};
  for (const int sweeps : {3, 5}) figures.push_back(motion(exec, TissueLaw::kSolid, 0.004, sweeps, aslant));
  if (!quick) {
    figures.push_back(motion(exec, TissueLaw::kSolid, 0.004, 5, {}));
    figures.push_back(motion(exec, TissueLaw::kSolid, 0.003, 5, {0.5, 0.2, 110}));
    figures.push_back(motion(exec, TissueLaw::kSolid, 0.004, 5, {0.5, 0.3, 30, 2}));
  }
  figures.push_back(motion(exec, TissueLaw::kSprings, 0.004, 5, {}));
  figures.back().known_limit = true;
  figures.push_back(motion(exec, TissueLaw::kSprings, 0.004, 50, {}));
}

// ---------------------------------------------------------------- a ball on a layer

/// Force of a ball on a layer of `layers` cells, of the formula's.
double press_layer(const Exec& exec, double poisson, int layers, double step, double circle) {
  constexpr double kRadius = 0.04;
  const auto [depth, wanted] = hayes_sphere({layers * step, {kYoung, poisson}}, kRadius, circle);

  const int side = 2 * (int(std::lround(circle / step)) + 3 * layers) + 1;
  Params params;
  params.tissue = {.law = TissueLaw::kSolid, .poisson = poisson};
  params.skin.enabled = false;
  params.solver = {.sweeps = 20, .damping = 8};
  const Model model = lattice::block_model({.size = {side, side, layers + 1},
                                            .step = step,
                                            .young = kYoung,
                                            .is_fixed = [](Int3 p) { return p.z == 0; }},
                                           params);
  State state = lattice::make_state(model);
  const lattice::BodySurface surface = lattice::build_surface(model, state);
  double top = 0;
  for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
  const double middle = 0.5 * (side - 1) * step;
  const std::vector<contact::Tool> tools = {{contact::Sphere{kRadius}, 0}};
  std::vector<contact::ToolPose> at = {{{{middle, middle, top + kRadius}, {}}, false}};
  std::vector<contact::ToolForce> forces(1);
  contact::LatticeTouch touch = contact::make_lattice_touch(model, state, surface, at);
  for (int n = 1; n <= 60; n++) {
    at[0].pose.position.z = top + kRadius - depth * std::min(1.0, n / 15.0);
    contact::step(exec, model, state, touch, tools, at, {}, 1.0 / 60, forces);
  }
  return forces[0].force.z / wanted;
}

}  // namespace

void add_wounds(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  add_steps(exec, quick, figures);
  for (const TissueLaw law : {TissueLaw::kSolid, TissueLaw::kSprings}) add_rates(exec, law, quick, figures);
  add_ts(exec, quick, figures);
  add_motion(exec, quick, figures);
}

void add_layers(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  for (const double poisson : {0.3, 0.45})
    for (const auto& [layers, circle] : quick ? std::vector{std::pair{6, 0.008}}
                                              : std::vector{std::pair{6, 0.008}, {10, 0.008}, {10, 0.012}})
      figures.push_back(
          near_figure(fmt::format("a ball on a layer of {} cells of solid, v {}, circle {:.0f} mm", layers,
                                  poisson, 1e3 * circle),
                      "Hayes et al.", press_layer(exec, poisson, layers, 0.002, circle), 1, 0.08));
}

}  // namespace turgor
