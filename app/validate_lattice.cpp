// Lattice against Hooke's law, its own weight applied as forces, the prescribed skin tension, and the opening
// of a slit in an elastic plane.
#include <cmath>

#include "app/validate_curved_wound.hpp"
#include "app/validate_wound.hpp"
#include "app/validation.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

namespace {

using lattice::Block;
using lattice::Model;
using lattice::Params;
using lattice::State;

constexpr double kSpacing = 0.004, kFrame = 1.0 / 60;

/// A bar of n × m × m nodes along an axis, held at its lower end.
Model bar(int axis, int n, int m, double young, const lattice::SolverParams& solver) {
  Int3 size{m, m, m};
  size[axis] = n;
  Params params;
  params.skin.enabled = false;
  params.solver = solver;
  return lattice::block_model({.size = size,
                               .spacing = kSpacing,
                               .young = young,
                               .skin_on_top = false,
                               .is_fixed = [axis](Int3 p) { return p[axis] == 0; }},
                              params);
}

template <class Visit>
void visit_end(const Model& model, int axis, const Visit& visit) {
  const Int3 size = model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (const Int3 p{i, j, k}; p[axis] == size[axis] - 1) visit(node_slot(model.anatomy.lattice, p));
}

/// Mean displacement of the free end along an axis after `frames` frames [m].
double settled_end(const Exec& exec, const Model& model, const lattice::Inputs& inputs, int bar_axis,
                   int axis, int frames) {
  State state = make_state(model);
  for (int n = 0; n < frames; n++) lattice::step(exec, model, state, inputs, kFrame);
  double sum = 0;
  int count = 0;
  visit_end(model, bar_axis,
            [&](int slot) { sum += double(state.motion.u[std::size_t(slot)][axis]), count++; });
  return sum / count;
}

/// Elongation of a bar under an end force, relative to F L / (E A).
double stretch(const Exec& exec, int axis) {
  constexpr int kLong = 41, kWide = 7;
  constexpr double kYoung = 1e4, kStrain = 0.01;
  const Model model = bar(axis, kLong, kWide, kYoung, {.sweeps = 40, .damping = 8});
  const double area = kWide * kWide * kSpacing * kSpacing;
  Vec3 force;
  force[axis] = Real(kYoung * area * kStrain / (kWide * kWide));
  std::vector<lattice::NodeLoad> loads;
  visit_end(model, axis, [&](int slot) { loads.push_back({slot, force}); });
  return settled_end(exec, model, {.loads = loads}, axis, axis, 200) / (kStrain * (kLong - 1) * kSpacing);
}

/// Bending of a bar along one axis by a force along another, relative to Timoshenko's beam with G = 0.4 E.
double bending(const Exec& exec, int along, int across) {
  constexpr int kLong = 31, kWide = 5;
  constexpr double kYoung = 1e5;
  const Model model = bar(along, kLong, kWide, kYoung, {.sweeps = 60, .damping = 8});
  const double length = (kLong - 1) * kSpacing, side = kWide * kSpacing, area = side * side;
  const double inertia = side * side * side * side / 12;
  const double wanted = 0.02 * length;
  const double compliance =
      length * length * length / (3 * kYoung * inertia) + length / (5.0 / 6 * 0.4 * kYoung * area);
  Vec3 force;
  force[across] = Real(wanted / compliance / (kWide * kWide));
  std::vector<lattice::NodeLoad> loads;
  visit_end(model, along, [&](int slot) { loads.push_back({slot, force}); });
  return settled_end(exec, model, {.loads = loads}, along, across, 400) / wanted;
}

/// Sag by gravity, relative to the sag with the weight applied as a force at every node.
double sag_by_gravity(const Exec& exec, int along, int across) {
  const Model model = bar(along, 25, 6, 2e5, {.sweeps = 5, .damping = 8});
  std::vector<lattice::NodeLoad> loads;
  Vec3d gravity;
  gravity[across] = -9.81;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const Real w = model.anatomy.inverse_mass[s]; w > 0) loads.push_back({int(s), Vec3(gravity) / w});
  const double by_gravity = settled_end(exec, model, {.gravity = gravity}, along, across, 300);
  return by_gravity / settled_end(exec, model, {.loads = loads}, along, across, 300);
}

/// Tension of a sheet of skin across a section, relative to the prescribed one. It is the difference of
/// energies at small stretches, minus the contribution of the tissue's prestress.
double skin_tension(double along, double across, bool along_x) {
  constexpr int kN = 13;
  constexpr double kSheet = 0.002, kStretch = 2e-3;
  Params params;
  params.skin.tension_along = along, params.skin.tension_across = across;
  const Model model = lattice::block_model({.size = {kN, kN, 1}, .spacing = kSheet, .young = 1e-3}, params);
  const int axis = along_x ? 0 : 1;
  double energies[2];
  for (const int side : {0, 1}) {
    State state = make_state(model);
    for (int j = 0; j < kN; j++)
      for (int i = 0; i < kN; i++) {
        Vec3 u;
        u[axis] = Real((side ? kStretch : -kStretch) * kSheet * (along_x ? i : j));
        state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, i, j, 0)), u);
      }
    energies[side] = lattice::energy(Exec(1), model, state);
  }
  double prestress = 0;
  for (std::size_t at = 0; at < model.prestress_force.size(); at++) {
    const Int3 p = slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[at]);
    prestress += double(model.prestress_force[at][axis]) * kSheet * p[axis];
  }
  const double side = (kN - 1) * kSheet;
  return ((energies[1] - energies[0]) / (2 * kStretch) - prestress) / (side * side) /
         (along_x ? along : across);
}

/// Gape of a slit in a tense sheet, relative to a crack in an orthotropic elastic plane [Westergaard 1939;
/// Sih, Paris, Irwin 1965].
double gape(const Exec& exec, double step, double half_length) {
  constexpr double kTension = 6, kStiffness = 300, kShear = 100;
  const int n = 20 * int(std::lround(half_length / step)) + 1;  // fixed at ten half lengths
  Block block{.size = {n, n, 1}, .spacing = step, .young = 0.5};
  block.is_fixed = [n](Int3 p) { return p.x == 0 || p.y == 0 || p.x == n - 1 || p.y == n - 1; };
  Params params;
  params.skin = {.tension_along = kTension,
                 .tension_across = kTension,
                 .stiffness = kStiffness,
                 .shear = kShear,
                 .amplification = 0};
  params.solver = {.sweeps = 40, .damping = 0};
  const Model model = lattice::block_model(block, params);
  State state = make_state(model);
  const double middle = (n - 1) / 2 * step, y = middle + 0.5 * step;
  const lattice::BladePath path =
      lay_blade(model, state,
                {.from = {middle - half_length, y, 0}, .to = {middle + half_length, y, 0}, .depth = 2 * step})
          .value();
  cut_edges(model, state, path, 0, 1, 0);
  const int frames = n * n / 120;  // time for the smooth error of few sweeps to decay
  for (int i = 0; i < frames; i++) lattice::step(exec, model, state, {}, 0.1);
  const double expected =
      4 * kTension * half_length / kStiffness * std::sqrt((1 + kStiffness / (2 * kShear)) / 2);
  return measure_wound(model, state, path, 0).gape_max / expected;
}

}  // namespace

std::vector<Figure> validate_lattice(const Exec& exec, bool quick) {
  std::vector<Figure> figures;
  const char* axes = "xyz";
  for (int axis = 0; axis < 3; axis++)
    figures.push_back(near_figure(std::string("bar along ") + axes[axis] + " stretched", "F L / (E A)",
                                  stretch(exec, axis), 1, 0.03));
  for (const auto& [along, across] : {std::pair{0, 1}, {1, 2}, {2, 0}})
    figures.push_back(near_figure(std::string("bar along ") + axes[along] + " bent along " + axes[across],
                                  "Timoshenko", bending(exec, along, across), 1, 0.06));
  for (const auto& [along, across] : {std::pair{0, 2}, {2, 1}})
    figures.push_back(
        near_figure(std::string("bar along ") + axes[along] + ", sag along " + axes[across] + " by gravity",
                    "the same weight as forces on its nodes", sag_by_gravity(exec, along, across), 1, 0.002));
  for (const auto& [along, across] : {std::pair{45.0, 45.0}, {60.0, 30.0}, {10.0, 150.0}})
    for (const bool x : {true, false})
      figures.push_back(near_figure(std::string("skin of ") + std::to_string(int(along)) + " and " +
                                        std::to_string(int(across)) + " N/m: tension across a section " +
                                        (x ? "along" : "across") + " the lines",
                                    "prescribed", skin_tension(along, across, x), 1, 0.005));
  for (const double step : {0.002, 0.001})
    figures.push_back(
        near_figure("gape of a slit of 12 mm, spacing " + std::to_string(1e3 * step).substr(0, 3) + " mm",
                    "crack in an elastic plane", gape(exec, step, 0.006), 1, 0.04));
  add_layers(exec, quick, figures);
  add_wounds(exec, quick, figures);
  if (!quick) add_curved_wounds(exec, figures);
  return figures;
}

}  // namespace turgor
