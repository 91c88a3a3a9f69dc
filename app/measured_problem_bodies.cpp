// Problems with closed or published results, solved by bodies of lattice cells: blocks whose surface is
// moved, beams that bend far, and relaxation.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/format.h>

#include "app/measured_table.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"

namespace turgor {

namespace {

using lattice::SolidEnergy;

constexpr double kFrameTime = 1.0 / 60, kBlockShear = 2e3;

MeasuredRow near_row(const std::string& name, const char* source, const char* unit, double expected,
                     double found) {
  return band_row(name, source, unit, expected, 0.01 * std::abs(expected), found);
}

lattice::Params problem_params(SolidEnergy energy, double poisson, double stiffening) {
  lattice::Params params;
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.tissue.energy = energy;
  params.tissue.poisson = poisson;
  params.tissue.stiffening = stiffening;
  params.solver.sweeps = 30, params.solver.damping = 20;
  return params;
}

/// Block whose nodes are held where `target` gives a displacement, settled from a displacement that grows.
struct MovedBlock {
  lattice::Model model;
  lattice::State state;
  std::vector<lattice::NodeContact> contacts;
  Int3 size;

  template <class Target>
  MovedBlock(const Exec& exec, Int3 nodes, double spacing, double young, const lattice::Params& params,
             const Target& target)
      : model(lattice::block_model({.size = nodes, .spacing = spacing, .young = young, .skin_on_top = false},
                                   params)),
        state(make_state(model)),
        size(nodes) {
    std::vector<Vec3d> targets;
    for (int k = 0; k < size.z; k++)
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++)
          if (const std::optional<Vec3d> held = target(Int3{i, j, k})) {
            contacts.push_back({.slot = node_slot(model.anatomy.lattice, {i, j, k}), .is_held = true});
            contacts.back().target = Vec3(*held);
          }
    std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
    std::vector<lattice::NodeContact> full = contacts;
    constexpr int kGrowing = 40, kFrames = 120;
    for (int n = 1; n <= kFrames; n++) {
      for (std::size_t c = 0; c < full.size(); c++)
        contacts[c].target = full[c].target * Real(std::min(1.0, double(n) / kGrowing));
      lattice::step(exec, model, state, {.contacts = contacts}, kFrameTime);
    }
  }
  /// Sum of the forces that hold the layer k [N].
  Vec3d force_on_layer(int k) const {
    Vec3d sum;
    for (const lattice::NodeContact& c : contacts)
      if (slot_node(model.anatomy.lattice, c.slot).z == k) sum += Vec3d(c.force);
    return sum;
  }
};

bool is_at_surface(Int3 p, Int3 size) {
  for (int axis = 0; axis < 3; axis++)
    if (p[axis] == 0 || p[axis] == size[axis] - 1) return true;
  return false;
}

/// Blocks whose surface takes a homogeneous deformation; the force on the top is compared. Forces on the rim
/// of the top come from the sides too, so that cells below the top are compared by their stress.
void add_blocks(const Exec& exec, MeasuredResult& result) {
  constexpr Int3 kSize{6, 6, 6};
  constexpr double kSpacing = 0.004;
  for (const double poisson : {0.45, 0.49, 0.499}) {
    const double stretch = 0.9, young = 2 * kBlockShear * (1 + poisson);
    const lattice::LawRatios ratios = lattice::law_ratios(SolidEnergy::kExponential, poisson);
    const MovedBlock block(exec, kSize, kSpacing, young,
                           problem_params(SolidEnergy::kExponential, poisson, 4), [&](Int3 p) {
                             std::optional<Vec3d> held;
                             if (is_at_surface(p, kSize)) held = Vec3d{0, 0, (stretch - 1) * kSpacing * p.z};
                             return held;
                           });
    const double third = std::cbrt(stretch), invariant = (2 + stretch * stretch) / (third * third);
    const double expected =
        2 * kBlockShear / 3 * std::exp(4 * (invariant - 3)) * (third - std::pow(stretch, -5.0 / 3)) +
        ratios.bulk * young * (stretch - 1);
    // the sides bear nothing along z in a homogeneous state, so that the top's force is the stress times its
    // area
    const double side = (kSize.x - 1) * kSpacing;
    result.rows.push_back(near_row(
        fmt::format("block of exponential cells, confined to 0.9, Poisson's ratio {}: nominal stress",
                    poisson),
        "closed form", "Pa", expected, block.force_on_layer(kSize.z - 1).z / (side * side)));
  }
}

/// Tip deflection over length of a cantilever with the dead tip load P at P L²/EI, by shooting: EI θ'' = −P
/// x' [Bisshopp, Drucker 1945], with the strain of a beam of ν = 0 and the height h [Reissner 1972]:
///   x' = (1 + ε) cos θ − γ sin θ, y' = (1 + ε) sin θ + γ cos θ, ε = P sin θ/EA, γ = P cos θ/(5/6 GA)
double elastica(double load, double height_over_length) {
  const double slender = height_over_length * height_over_length / 12;  // I/(A L²)
  const auto shoot = [&](double slope, double& deflection) {
    double theta = 0, curvature = slope;
    deflection = 0;
    constexpr int kSteps = 2000;
    const double h = 1.0 / kSteps;
    const auto along = [&](double angle) {
      const double e = load * slender * std::sin(angle), g = 2.4 * load * slender * std::cos(angle);
      return std::array{(1 + e) * std::cos(angle) - g * std::sin(angle),
                        (1 + e) * std::sin(angle) + g * std::cos(angle)};
    };
    for (int n = 0; n < kSteps; n++) {  // midpoint rule
      const double middle = theta + 0.5 * h * curvature;
      const auto [x, y] = along(middle);
      theta += h * (curvature - 0.5 * h * load * along(theta)[0]);
      curvature -= h * load * x, deflection += h * y;
    }
    return curvature;
  };
  double low = 0, high = 2 * load, deflection = 0;
  for (int n = 0; n < 60; n++) (shoot((low + high) / 2, deflection) > 0 ? high : low) = (low + high) / 2;
  return deflection;
}

constexpr Int3 kBeam{96, 8, 8};  // cells

/// The same for a beam of kBeam cells. Narrow beams turn sideways.
double bent_beam(const Exec& exec, double load) {
  constexpr int kLong = kBeam.x, kWide = kBeam.y, kHigh = kBeam.z;
  constexpr double kSpacing = 0.001, kYoung = 2e5;
  lattice::Params params = problem_params(SolidEnergy::kNeoHookean, 0, 0);
  params.solver.damping = 6;
  const lattice::Model model = lattice::block_model({.size = {kLong + 1, kWide + 1, kHigh + 1},
                                                     .spacing = kSpacing,
                                                     .young = kYoung,
                                                     .skin_on_top = false,
                                                     .is_fixed = [](Int3 p) { return p.x == 0; }},
                                                    params);
  const double wide = kWide * kSpacing, high = kHigh * kSpacing, length = kLong * kSpacing;
  const double force = load * kYoung * wide * high * high * high / 12 / (length * length);
  std::vector<lattice::NodeLoad> loads;
  const auto share = [](int i, int count) { return (i == 0 || i == count ? 0.5 : 1.0) / count; };
  for (int k = 0; k <= kHigh; k++)
    for (int j = 0; j <= kWide; j++)
      loads.push_back({node_slot(model.anatomy.lattice, {kLong, j, k}),
                       Vec3{0, 0, Real(-force * share(j, kWide) * share(k, kHigh))}});
  std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  lattice::State state = make_state(model);
  for (int n = 0; n < 360; n++) lattice::step(exec, model, state, {.loads = loads}, kFrameTime);
  const auto tip = std::size_t(node_slot(model.anatomy.lattice, {kLong, kWide / 2, kHigh / 2}));
  return -double(state.motion.u[tip].z) / length;
}

/// Stress xz of a viscous block over its static modulus, sheared by γ(t).
struct ShearedBlock {
  lattice::Model model;
  lattice::State state;

  explicit ShearedBlock(const Prony& prony) {
    lattice::Params params = problem_params(SolidEnergy::kNeoHookean, 0.4, 0);
    params.tissue.prony = prony;
    model = lattice::block_model({.size = {4, 3, 3}, .young = 1e4, .skin_on_top = false}, params);
    state = make_state(model);
  }
  double advance(const Exec& exec, double gamma, double dt) {
    const Lattice& l = model.anatomy.lattice;
    begin_viscous_step(exec, model, state, dt);
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (int i = 0; i < l.size.x; i++) {
          const Vec3 x = rest_position(l, {i, j, k});
          state.motion.u.set(std::size_t(node_slot(l, {i, j, k})), {Real(gamma) * x.y, 0, 0});
        }
    end_viscous_step(exec, model, state, dt);
    // stress of the first cell
    const int slot = node_slot(l, {0, 0, 0});
    Real young[lattice::kGroup] = {model.anatomy.cell_young[std::size_t(slot)]};
    lattice::LawStresses<lattice::kGroup> stresses;
    law_stresses(node_arrays(model, state), cell_law_view(model, state), lattice::node_block(l, 0), young,
                 slot, stresses);
    double sum = double(stresses.of[3][0]);
    for (const lattice::SymmetricField& field : state.viscosity.history)
      sum += double(field.xy[std::size_t(slot)]);
    return sum / (double(l.spacing.x) * l.spacing.y * l.spacing.z * 1e4 / 2.8);
  }
};

void add_relaxation(const Exec& exec, MeasuredResult& result) {
  Prony prony;
  prony.pairs = {PronyPair{0.8, 0.05}, PronyPair{0.5, 0.4}, PronyPair{0.3, 3}};
  constexpr double kGamma = 0.02;
  // a ramp of 0.2 s, then a hold to 1 s
  ShearedBlock held(prony);
  double stress = 0;
  for (int n = 1; n <= 200; n++) stress = held.advance(exec, kGamma * std::min(1.0, n / 40.0), 0.005);
  double expected = 1;
  for (const auto& [ratio, time] : prony.pairs)
    expected += ratio * time / 0.2 * -std::expm1(-0.2 / time) * std::exp(-0.8 / time);
  result.rows.push_back(
      near_row("three Prony pairs, sheared in 0.2 s and held to 1 s: stress over the static one",
               "closed form", "1", expected, stress / kGamma));
  // oscillation: |G*|/G = |1 + Σ p iωτ/(1 + iωτ)|
  const double omega = 2 * std::numbers::pi;
  std::complex<double> dynamic = 1;
  for (const auto& [ratio, time] : prony.pairs)
    dynamic += ratio * std::complex<double>(0, omega * time) / std::complex<double>(1, omega * time);
  ShearedBlock shaken(prony);
  double largest = 0;
  for (int n = 1; n <= 3000; n++) {
    const double s = shaken.advance(exec, kGamma * std::sin(omega * n * 0.005), 0.005);
    if (n > 2800) largest = widest(largest, s);
  }
  result.rows.push_back(
      near_row("three Prony pairs, shaken at 1 Hz: amplitude of the stress over the static one",
               "closed form", "1", std::abs(dynamic), largest / kGamma));
}

}  // namespace

void add_body_problems(const Exec& exec, bool quick, MeasuredResult& result) {
  add_relaxation(exec, result);
  add_blocks(exec, result);
  if (quick) return;
  for (const double load : {1.0, 2.0, 5.0})
    result.rows.push_back(
        near_row(fmt::format("cantilever of lattice cells, P L²/EI = {}: deflection of the tip "
                             "over the length",
                             load),
                 "Bisshopp and Drucker 1945, Reissner 1972", "1", elastica(load, double(kBeam.z) / kBeam.x),
                 bent_beam(exec, load)));
}

}  // namespace turgor
