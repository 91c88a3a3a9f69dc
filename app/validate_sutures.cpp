#include "app/validate_sutures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/lens_elements.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor {

namespace {

using namespace lattice;

constexpr double kFrameTime = 1.0 / 60;  // [s]

/// Solid tissue under skin with tensions along x and y [N/m].
Params skin_params(double along, double across) {
  Params params;
  params.tissue = {.law = TissueLaw::kSolid, .poisson = 0.45};
  params.skin.tension_along = along, params.skin.tension_across = across;
  params.skin.direction = {1, 0, 0};
  params.solver = {.sweeps = 6, .damping = 3};
  return params;
}

/// Body with a wound.
struct Wounded {
  Model model;
  State state;
  BladePath path;
};

/// Steps a body while its stitches are pulled and come to rest.
void sew(const Exec& exec, const Pull& pull, int steps, Wounded& body, WoundClosure& closure) {
  for (int n = 1; n <= steps; n++) {
    pull_stitches(body.state.motion, pull, n * kFrameTime, closure);
    PointSprings springs;
    append_springs(closure, springs.all);
    make_terms(springs);
    springs.refresh = [&](const State& now) { update_springs(body.model, now.motion, closure, springs.all); };
    (void)step(exec, body.model, body.state, {.springs = &springs}, kFrameTime);
    update_multipliers(body.model, body.state.motion, closure);
  }
}

/// A bar that is held at its ends and cut through near its middle.
struct BarCase {
  const char* name;
  Int3 size;
  double spacing, young, tension;  // [m] [Pa] [N/m]
};
constexpr BarCase kBars[] = {{"bar of 96 x 40 x 20 mm", {25, 11, 6}, 0.004, 1.2e4, 30},
                             {"bar of 120 x 30 x 24 mm", {41, 11, 9}, 0.003, 8e3, 42}};

Wounded cut_bar(const BarCase& c) {
  Block block{.size = c.size, .spacing = c.spacing, .young = c.young};
  block.is_fixed = [&c](Int3 p) { return p.x == 0 || p.x == c.size.x - 1; };
  Wounded body;
  body.model = block_model(block, skin_params(c.tension, c.tension));
  body.state = make_state(body.model);
  const double x = (c.size.x / 2 + 0.37) * c.spacing, z = (c.size.z - 1) * c.spacing;
  body.path = required(lay_blade(
      body.model, body.state,
      {.from = {x, 0, z}, .to = {x, (c.size.y - 1) * c.spacing, z}, .depth = c.size.z * c.spacing}));
  cut_edges(body.model, body.state, body.path, 0, 1, 0);
  return body;
}

/// Force through the section behind a column of nodes, by a difference of energies that have no prestress
/// [N].
double section_force(const Exec& exec, const Wounded& body, int column) {
  constexpr double kShift = 1e-4;  // [m]
  const Model& model = body.model;
  double energies[2], prestress = 0;
  for (const int side : {0, 1}) {
    State moved = body.state;
    for (std::size_t s = 0; s < model.anatomy.tissue.size(); s++)
      if (has_node(model, int(s)) && slot_node(model.anatomy.lattice, int(s)).x <= column)
        moved.motion.u.x[s] += Real(side ? kShift : -kShift);
    energies[side] = energy(exec, model, moved);
  }
  for (std::size_t n = 0; n < model.prestress_force.size(); n++)
    if (slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[n]).x <= column)
      prestress += double(model.prestress_force[n].x);
  return prestress - (energies[1] - energies[0]) / (2 * kShift);
}

void add_bars(const Exec& exec, std::vector<Figure>& figures) {
  for (const BarCase& c : kBars) {
    Wounded body = cut_bar(c);
    WoundClosure closure =
        required(lay_stitches(body.model, body.state.cuts, body.path, {.spacing = 0.009, .bite = 0.006}));
    closure.thread = {.stiffness = 72, .strength = 50}, closure.pull_out = 50;
    sew(exec, {.duration = 0.4}, 200, body, closure);
    double gape = 0;
    for (const Stitch& stitch : closure.stitches) gape = widest(gape, gape_under(stitch, body.state.motion));
    figures.push_back(near_figure(fmt::format("{}: closing force", c.name), "force through a section",
                                  closing_force(closure, body.state.motion), section_force(exec, body, 4),
                                  0.01));
    figures.push_back(
        most_figure(fmt::format("{}: gape under a stitch", c.name), "lips that meet", "m", gape, 3e-4));
  }
}

/// Running threads in tissue that is held. The last stitch is pulled.
void add_running(std::vector<Figure>& figures) {
  const Wounded body = cut_bar(kBars[0]);
  for (const double friction : {0.02, 0.06, 0.12}) {
    WoundClosure closure = required(lay_stitches(body.model, body.state.cuts, body.path,
                                                 {.spacing = 0.009, .bite = 0.006, .is_running = true}));
    closure.thread = {.stiffness = 90, .strength = 1e3, .friction = friction}, closure.pull_out = 1e3;
    for (Stitch& stitch : closure.stitches)
      stitch.phase = StitchPhase::kKnotted, stitch.length = loop_length(stitch, body.state.motion);
    closure.stitches.back().length *= 0.93;
    const double thread = thread_length(closure);
    PointSprings springs;
    append_springs(closure, springs.all);
    for (int n = 0; n < 5000; n++) {
      update_springs(body.model, body.state.motion, closure, springs.all);
      update_multipliers(body.model, body.state.motion, closure);
    }
    const std::size_t last = closure.stitches.size() - 1;
    const double ratio = closure.stitches[last].tension / closure.stitches[0].tension;
    const std::string name = fmt::format("running thread, friction {}: ", friction);
    figures.push_back(near_figure(name + fmt::format("ratio of tensions over {} stitches", last),
                                  "exp(mu theta)", ratio,
                                  std::exp(friction * 2 * std::numbers::pi * double(last)), 0.02));
    figures.push_back(most_figure(name + "change of its length", "thread is kept", "1",
                                  std::abs(thread_length(closure) / thread - 1), 1e-9));
  }
}

/// Lens that a wide membrane on little tissue loses, and its closing force [N].
struct MembraneCase {
  double spacing, bite, along, across, angle;  // [m] [m] [N/m] [N/m] [degrees]
};
constexpr double kLens = 0.036, kLensWidth = 0.0105, kMembrane = 400;  // [m] [m] [N/m]
constexpr double kLensSide = 0.12, kLensTissue = 0.009;                // of the block [m]
constexpr double kLensDepth = 0.0066;                                  // of the wound [m]
constexpr int kLensStitches = 12;
// The elements have no tissue. A deep strand that hangs in cells below the skin pulls on soft nodes as well,
// which costs a tenth of the force at 0.2 mm and a spacing of 1.5 mm.
constexpr double kInSkin = 2e-5;  // depth of the deep strands [m]

double close_membrane(const Exec& exec, const MembraneCase& c) {
  const int nodes = int(std::lround(kLensSide / c.spacing)) + 1;
  const int layers = int(std::lround(kLensTissue / c.spacing));
  Block block{.size = {nodes, nodes, layers + 1}, .spacing = c.spacing, .young = 1000};
  block.is_fixed = [nodes](Int3 p) { return p.x == 0 || p.y == 0 || p.x == nodes - 1 || p.y == nodes - 1; };
  Params params = skin_params(c.along, c.across);
  params.tissue.poisson = 0.3;
  params.skin.stiffness = kMembrane, params.skin.shear = kMembrane / 2, params.skin.amplification = 0;
  Wounded body;
  body.model = block_model(block, params);
  body.state = make_state(body.model);
  const Excision lens{
      .center = {(nodes / 2 + 0.31) * c.spacing, (nodes / 2 + 0.17) * c.spacing, layers * c.spacing},
      .direction = {1, 0, 0},
      .angle = c.angle,
      .length = kLens,
      .width = kLensWidth};
  Incision blade{.name = "lens", .depth = kLensDepth};
  blade.path = required(excision_outline(body.model, body.state, lens)), blade.excision = lens;
  body.path = required(lay_blade(body.model, body.state, blade));
  cut_edges(body.model, body.state, body.path, 0, 1, 0);
  excise(body.model, body.state, required(find_piece(body.model, body.state.cuts, 0)));
  WoundClosure closure =
      required(lay_stitches(body.model, body.state.cuts, body.path,
                            {.spacing = kLens / kLensStitches, .bite = c.bite, .depth = kInSkin}));
  // a membrane has no walls
  closure.walls.clear();
  closure.thread = {.stiffness = 200, .strength = 50}, closure.pull_out = 50;
  // the stitches keep the length with which the lips meet
  for (Stitch& stitch : closure.stitches) stitch.shortest = rest_length(stitch);
  sew(exec, {.duration = 0.75}, 120, body, closure);
  return closing_force(closure, body.state.motion);
}

/// A lens in a membrane with tension T and stiffness E is closed by the force T L + E w/π of dislocations, if
/// the membrane is endless and the lens narrow. Elements have the sides of the block, the stitches, and large
/// displacements: together 25 to 38 % more.
void add_lenses(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  const double spacing = quick ? 0.00225 : 0.0015;
  double force[2], expected[2];
  constexpr double kTensions[2] = {20, 50};
  for (const int n : {0, 1}) {
    force[n] = close_membrane(exec, {spacing, spacing, kTensions[n], kTensions[n], 10});
    expected[n] = closing_force_of_elements({.side = kLensSide,
                                             .length = kLens,
                                             .width = kLensWidth,
                                             .tension = kTensions[n],
                                             .stiffness = kMembrane,
                                             .stitches = kLensStitches,
                                             .bite = spacing,
                                             .patch = spacing},
                                            24);
    figures.push_back(near_figure(
        fmt::format("lens, tension {} N/m, lattice of {} mm: closing force", kTensions[n], 1e3 * spacing),
        "membrane of elements", force[n], expected[n], 0.1));
  }
  figures.push_back(near_figure("lens: change of the closing force with the tension", "membrane of elements",
                                force[1] - force[0], expected[1] - expected[0], 0.15));
  const MembraneCase along{0.003, 0.0045, 60, 15, 0}, across{0.003, 0.0045, 60, 15, 90};
  figures.push_back(near_figure("lens across the lines of tension, less along them", "L (60 - 15 N/m)",
                                close_membrane(exec, across) - close_membrane(exec, along), 45 * kLens,
                                0.15));
}

}  // namespace

void add_sutures(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  add_bars(exec, figures);
  add_running(figures);
  add_lenses(exec, quick, figures);
}

}  // namespace turgor
