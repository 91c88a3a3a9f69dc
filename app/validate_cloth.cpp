// Cloth against strips, sheets and ropes with known answers: catenary, period of a hanging chain, terminal
// velocity, wind pressure, fold energy.
#include <cmath>
#include <numbers>
#include <tuple>

#include "app/validate_cloth_sheet.hpp"
#include "app/validation.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/measure.hpp"

namespace turgor {

namespace {

using cloth::Inputs;
using cloth::Model;
using cloth::Params;
using cloth::State;

constexpr double kFrame = 1.0 / 60, kGravity = 9.81;

Inputs in_vacuum() {
  Inputs inputs{.gravity = {0, 0, -kGravity}};
  inputs.air.density = 0;
  return inputs;
}

/// A strip of this length along x, one cell wide in y.
Model strip(const Exec& exec, double length, int cells, const Params& params) {
  const TriMesh mesh =
      cloth::make_sheet({.side = {length, 0, 0}, .up = {0, length / cells, 0}, .columns = cells, .rows = 1});
  return std::move(*cloth::build(exec, mesh, params));
}

/// Vertices of a column of the strip; a sheet is numbered row by row.
std::vector<int> column(int cells, int c) { return {c, cells + 1 + c}; }

void hold_column(const Model& model, State& state, int cells, int c) {
  for (const int v : column(cells, c)) {
    const Status held = hold(model, state, v);
    TURGOR_ASSERT(held, "the strip has this vertex");
  }
}

void move(const Model& model, State& state, int vertex, Vec3d goal) {
  const Status moved = move_hold(model, state, vertex, Vec3(goal));
  TURGOR_ASSERT(moved, "the strip has this vertex, and it is held");
}

Vec3d position_of(const Model& model, const State& state, int vertex) {
  return Vec3d(state.x[std::size_t(model.model_vertex[std::size_t(vertex)])]);
}

Params stiff_strip(double motion) {
  Params params = sheet_params({.density = 0.2, .warp = 4000, .weft = 4000, .shear = 800});
  params.fabric.rigidity_warp = params.fabric.rigidity_weft = 1e-7;
  params.damping = {motion, 0};
  params.collision.self = false;
  return params;
}

/// Sag and end force of a strip with its ends closer than its length, relative to the catenary [1].
struct Catenary {
  double sag = 0, pull = 0;
};
Catenary hang_between(const Exec& exec, double length, double span, int cells) {
  const Model model = strip(exec, length, cells, stiff_strip(3));
  State state = cloth::make_state(model);
  const Inputs inputs = in_vacuum();
  constexpr int kMoveFrames = 120;
  for (const int c : {0, cells}) hold_column(model, state, cells, c);
  for (int n = 0; n < 900; n++) {
    for (const int v : column(cells, cells)) {
      Vec3d goal(model.x_rest[std::size_t(model.model_vertex[std::size_t(v)])]);
      goal.x -= (length - span) * std::min(1.0, (n + 1.0) / kMoveFrames);
      move(model, state, v, goal);
    }
    cloth::step(exec, model, state, inputs, kFrame);
  }
  double scale = span;  // c: length = 2 c sinh(span / 2c)
  for (int i = 0; i < 200; i++) {
    const double found = 2 * scale * std::sinh(span / (2 * scale));
    scale *= 1 + 0.3 * (found / length - 1);
  }
  const double sag = scale * (std::cosh(span / (2 * scale)) - 1);
  const double weight = model.total_mass / length * kGravity;  // per meter [N/m]
  Vec3d pull;
  for (const int v : column(cells, 0)) pull += cloth::hold_force(model, state, v, inputs.gravity, {}, kFrame);
  const double low =
      0.5 * (position_of(model, state, cells / 2).z + position_of(model, state, cells + 1 + cells / 2).z);
  return {-low / sag, norm(pull) / (weight * scale * std::cosh(span / (2 * scale)))};
}

/// Period of small swings of a strip that hangs from one end, relative to a rope's 4π/2.4048 √(L/g).
double rope_period(const Exec& exec, double length, int cells) {
  const Model model = strip(exec, length, cells, stiff_strip(0));
  State state = cloth::make_state(model);
  Inputs inputs = in_vacuum();
  inputs.gravity = {kGravity, 0, 0};  // the strip hangs along x
  hold_column(model, state, cells, 0);
  for (int c = 1; c <= cells; c++)
    for (const int v : column(cells, c)) {
      const double below = 1 - double(c) / cells;  // fraction of the rope below
      const double shape = std::cyl_bessel_j(0, 2.404825557695773 * std::sqrt(below));
      state.x.add(std::size_t(model.model_vertex[std::size_t(v)]), Vec3(Vec3d{0, 0, 0.02 * length * shape}));
    }
  const double step = kFrame / 8;
  double before = 0.02 * length, first = 0, last = 0;
  int crossings = 0;
  for (int n = 1; n < 12000 && crossings < 5; n++) {
    cloth::step(exec, model, state, inputs, step);
    const double now = position_of(model, state, cells).z;
    if (now * before < 0) {
      const double time = (n - now / (now - before)) * step;
      (crossings++ == 0 ? first : last) = time;
    }
    before = now;
  }
  const double expected = 4 * std::numbers::pi / 2.404825557695773 * std::sqrt(length / kGravity);
  return (last - first) / 2 / expected;
}

/// A free square of 13 cm without damping.
Model free_sheet(const Exec& exec) {
  Params params = sheet_params({});
  params.damping.motion = 0;
  const TriMesh mesh =
      cloth::make_sheet({.side = {0.13, 0, 0}, .up = {0, 0.13, 0}, .columns = 13, .rows = 13});
  return std::move(*cloth::build(exec, mesh, params));
}

/// Terminal velocity in still air, relative to √(2 ρ g / (ρ_air c)).
double fall_speed(const Exec& exec) {
  const Model model = free_sheet(exec);
  State state = cloth::make_state(model);
  const Inputs inputs{.gravity = {0, 0, -kGravity}};
  for (int n = 0; n < 300; n++) cloth::step(exec, model, state, inputs, kFrame);
  const double expected =
      std::sqrt(2 * model.params.fabric.density * kGravity / (inputs.air.density * inputs.air.pressure));
  return -double(state.v.z[40]) / expected;
}

/// Speed of a free sheet in a normal wind after 1 s, relative to the analytic solution.
double carried_speed(const Exec& exec) {
  const Model model = free_sheet(exec);
  State state = cloth::make_state(model);
  Inputs inputs;
  inputs.air.velocity = {0, 0, 3};
  const double start = 0.5 * inputs.air.density * inputs.air.pressure / model.params.fabric.density;  // 1/m
  const double seconds = 1;
  for (int n = 0; n < 240; n++) cloth::step(exec, model, state, inputs, seconds / 240);
  const double expected = 3 - 1 / (1 / 3.0 + start * seconds);  // dw/dt = −k w², w against the wind
  return double(state.v.z[40]) / expected;
}

/// Fold energy of a strip at twice a small angle, relative to the energy at that angle.
double fold_energy(const Exec& exec) {
  Params params = stiff_strip(0);
  params.fabric.rigidity_warp = 1e-3;
  constexpr int kCells = 2;
  const Model model = strip(exec, 0.2, kCells, params);
  const auto folded = [&](double angle) {
    State state = cloth::make_state(model);
    for (const int v : column(kCells, kCells)) {
      const auto slot = std::size_t(model.model_vertex[std::size_t(v)]);
      const Vec3d x(state.x[slot]);
      state.x.add(slot, Vec3(Vec3d{0.1 + 0.1 * std::cos(angle) - x.x, 0, 0.1 * std::sin(angle)}));
    }
    return cloth::energy(model, state, {}).elastic;
  };
  return folded(0.4) / folded(0.2);
}

}  // namespace

std::vector<Figure> validate_cloth(const Exec& exec, bool quick) {
  std::vector<Figure> figures;
  for (const auto& [length, span, cells] :
       {std::tuple{1.0, 0.8, 50}, {1.0, 0.8, 100}, {1.0, 0.8, 200}, {1.0, 0.5, 80}, {2.0, 1.7, 80}}) {
    const Catenary found = hang_between(exec, length, span, cells);
    const std::string name = "strip of " + std::to_string(int(1000 * length)) + " mm between ends " +
                             std::to_string(int(1000 * span)) + " mm apart, " + std::to_string(cells) +
                             " cells: ";
    figures.push_back(near_figure(name + "sag", "catenary", found.sag, 1, 0.01));
    figures.push_back(near_figure(name + "force at an end", "catenary", found.pull, 1, 0.01));
  }
  for (const auto& [length, cells] : {std::pair{0.5, 40}, {1.0, 50}, {1.0, 100}, {1.0, 200}})
    figures.push_back(near_figure("hanging strip of " + std::to_string(int(1000 * length)) + " mm in " +
                                      std::to_string(cells) + " cells: period",
                                  "Bernoulli's rope", rope_period(exec, length, cells), 1, 0.02));
  figures.push_back(
      near_figure("sheet falling in still air: speed", "weight = pressure", fall_speed(exec), 1, 0.01));
  figures.push_back(near_figure("sheet carried by a wind: speed after 1 s", "dw/dt = -k w^2",
                                carried_speed(exec), 1, 0.02));
  figures.push_back(
      near_figure("fold of twice the angle: energy", "a plate: 4 times", fold_energy(exec), 4, 0.05));
  add_sheet_figures(exec, quick, figures);
  return figures;
}

}  // namespace turgor
