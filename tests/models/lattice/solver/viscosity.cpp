// Viscous cells: relaxation under prescribed strains and creep under loads, against closed forms.
#include "turgor/models/lattice/solver/viscosity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/deformed_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwoThreads(2);
constexpr double kStiffness = 1e4;

Prony three_pairs() {
  Prony prony;
  prony.pairs = {PronyPair{0.8, 0.05}, PronyPair{0.5, 0.4}, PronyPair{0.3, 3}};
  return prony;
}

Model viscous_block(const Prony& prony, double poisson, SolidEnergy energy = SolidEnergy::kNeoHookean) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.energy = energy;
  params.tissue.stiffening = energy == SolidEnergy::kExponential ? 4 : 0;
  params.tissue.poisson = poisson;
  params.tissue.prony = prony;
  params.solver = {.sweeps = 12, .damping = 0};
  Block block{.size = {4, 3, 3}, .young = kStiffness, .skin_on_top = false};
  return block_model(block, params);
}

/// Stress S of the first cell with its relaxing part, over V E.
struct Tensor {
  double xx, yy, zz, xy, xz, yz;
};
Tensor stress_of_first(const Model& model, State& state) {
  const int slot = node_slot(model.anatomy.lattice, {0, 0, 0});
  Real young[kGroup] = {};
  young[0] = model.anatomy.cell_young[std::size_t(slot)];
  LawStresses<kGroup> elastic;
  law_stresses(node_arrays(model, state), cell_law_view(model, state), node_block(model.anatomy.lattice, 0),
               young, slot, elastic);
  const Vec3 h = model.anatomy.lattice.spacing;
  const double scale = double(h.x) * h.y * h.z * kStiffness;
  double s[6];
  for (std::size_t e = 0; e < 6; e++) {
    s[e] = double(elastic.of[e][0]);
    for (const SymmetricField& field : state.viscosity.history) {
      const aligned_vector<Real>* entries[] = {&field.xx, &field.yy, &field.zz,
                                               &field.xy, &field.xz, &field.yz};
      s[e] += double((*entries[e])[std::size_t(slot)]);
    }
    s[e] /= scale;
  }
  return {s[0], s[1], s[2], s[3], s[4], s[5]};
}

Mat3d shear_of(double gamma) { return {{Vec3d{1, 0, 0}, Vec3d{gamma, 1, 0}, Vec3d{0, 0, 1}}}; }
Mat3d turned(double angle, const Mat3d& f) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Mat3d r{{Vec3d{c, 0, -s}, Vec3d{0, 1, 0}, Vec3d{s, 0, c}}};
  return {{r * f.column[0], r * f.column[1], r * f.column[2]}};
}

// A sheared cell that is held relaxes as the closed form of a ramp and a hold, while it also turns.
TEST(LatticeViscosity, RampAndHoldMatchesClosedForm) {
  const Prony prony = three_pairs();
  const Model model = viscous_block(prony, 0.4);
  State state = make_state(model);
  constexpr double kStrain = 0.01, kRamp = 0.2, kStep = 0.01;
  const double shear = 0.5 / 1.4 * kStrain;  // µ γ, over E
  for (int n = 1; n <= 200; n++) {
    const double t = n * kStep;
    begin_viscous_step(kTwoThreads, model, state, kStep);
    deform(model, state, turned(0.8 * t, shear_of(kStrain * std::min(1.0, t / kRamp))));
    end_viscous_step(kTwoThreads, model, state, kStep);
    double expected = std::min(1.0, t / kRamp);
    for (const PronyPair& pair : prony.pairs) {
      const double loaded = std::min(t, kRamp), after = t - loaded;
      expected +=
          pair.ratio * pair.time / kRamp * -std::expm1(-loaded / pair.time) * std::exp(-after / pair.time);
    }
    EXPECT_NEAR(stress_of_first(model, state).xy, shear * expected, 0.01 * shear) << "at " << t << " s";
  }
}

// In rows of any length, each pair of each cell takes the stress of one sheared step: p (1 − a) τ/h µ γ.
// Cells beside the body keep nothing.
TEST(LatticeViscosity, EveryCellOfARowRelaxes) {
  constexpr double kStep = 0.02, kStrain = 0.01;
  const Prony prony = three_pairs();
  for (const int nodes : {4, 15, 18, 33, 40, 67}) {
    Params params;
    params.skin.enabled = false;
    params.tissue = {.law = TissueLaw::kSolid, .poisson = 0.4, .prony = prony};
    const Model model =
        block_model({.size = {nodes, 3, 3}, .young = kStiffness, .skin_on_top = false}, params);
    const Lattice& l = model.anatomy.lattice;
    State state = make_state(model);
    begin_viscous_step(kTwoThreads, model, state, kStep);
    deform(model, state, shear_of(kStrain));
    end_viscous_step(kTwoThreads, model, state, kStep);
    const Vec3d h(l.spacing);
    const double stress = 0.5 / 1.4 * kStrain * kStiffness * h.x * h.y * h.z;
    for (std::size_t p = 0; p < kMostPronyPairs; p++) {
      const double x = kStep / prony.pairs[p].time;
      const double expected = prony.pairs[p].ratio * -std::expm1(-x) / x * stress;
      double sum = 0;
      for (const Real entry : state.viscosity.history[p].xy) sum += double(entry);
      EXPECT_NEAR(sum, expected * (nodes - 1) * 4, 0.01 * expected * (nodes - 1) * 4) << nodes << " nodes";
      for (int i = 0; i + 1 < nodes; i++)
        EXPECT_NEAR(double(state.viscosity.history[p].xy[std::size_t(node_slot(l, {i, 1, 1}))]), expected,
                    0.01 * expected)
            << "cell " << i << " of " << nodes << " nodes";
    }
  }
}

/// Strain of a body with these pairs t seconds after a stress begins, over the static strain; by a fine
/// integration of σ = E ε + Σ qᵢ, dqᵢ/dt = pᵢ E dε/dt − qᵢ/τᵢ.
double creep(const Prony& prony, double t) {
  const double h = 1e-5, whole = 1 + total_ratio(prony);
  double strain = 1 / whole, q[kMostPronyPairs];
  for (std::size_t i = 0; i < kMostPronyPairs; i++) q[i] = prony.pairs[i].ratio * strain;
  for (double at = 0; at < t; at += h) {
    double loss = 0;
    for (std::size_t i = 0; i < kMostPronyPairs; i++) loss += q[i] / prony.pairs[i].time;
    const double rate = loss / whole;
    for (std::size_t i = 0; i < kMostPronyPairs; i++)
      q[i] += h * (prony.pairs[i].ratio * rate - q[i] / prony.pairs[i].time);
    strain += h * rate;
  }
  return strain;
}

// A free block under a constant tension creeps as the closed form.
TEST(LatticeViscosity, CreepMatchesClosedForm) {
  const Prony prony = three_pairs();
  const Model model = viscous_block(prony, 0.3);
  const Lattice& l = model.anatomy.lattice;
  const Vec3d h(l.spacing);
  constexpr double kTension = 50;  // Pa: a strain of 0.5 %
  std::vector<NodeLoad> loads;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (const int i : {0, l.size.x - 1}) {
        const double share =
            (j == 0 || j == l.size.y - 1 ? 0.5 : 1.0) * (k == 0 || k == l.size.z - 1 ? 0.5 : 1.0);
        loads.push_back(
            {node_slot(l, {i, j, k}), {Real((i == 0 ? -1 : 1) * kTension * share * h.y * h.z), 0, 0}});
      }
  std::sort(loads.begin(), loads.end(), [](const NodeLoad& a, const NodeLoad& b) { return a.slot < b.slot; });
  State state = make_state(model);
  double time = 0;
  for (const double until : {0.2, 0.6, 2.0}) {
    for (; time < until - 1e-9; time += 1.0 / 120)
      step(kTwoThreads, model, state, {.loads = loads}, 1.0 / 120);
    const double length = double(state.motion.u[std::size_t(node_slot(l, {l.size.x - 1, 1, 1}))].x) -
                          double(state.motion.u[std::size_t(node_slot(l, {0, 1, 1}))].x);
    const double strain = length / (h.x * (l.size.x - 1)) / (kTension / kStiffness);
    EXPECT_NEAR(strain, creep(prony, until), 0.02) << "of the static strain, after " << until << " s";
  }
}

// A closed loop of large strains takes energy and never gives some.
TEST(LatticeViscosity, ClosedLoopsTakeEnergy) {
  for (const SolidEnergy energy : {SolidEnergy::kNeoHookean, SolidEnergy::kExponential}) {
    const Model model = viscous_block(three_pairs(), 0.4, energy);
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> any(-0.15, 0.15);
    for (int loop = 0; loop < 6; loop++) {
      State state = make_state(model);
      Mat3d a, b;
      for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++)
          a.column[std::size_t(c)][r] = any(engine), b.column[std::size_t(c)][r] = any(engine);
      const double step = loop % 2 ? 0.005 : 0.05;
      double work = 0, scale = 0;
      Tensor before{};
      Mat3d last{{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
      const auto strain = [](const Mat3d& f, int r, int c) {
        return 0.5 * (dot(f.column[std::size_t(r)], f.column[std::size_t(c)]) - (r == c));
      };
      constexpr int kSteps = 120;
      for (int n = 1; n <= kSteps; n++) {
        const double angle = 2 * 3.14159265358979 * n / kSteps;
        Mat3d f;
        for (int c = 0; c < 3; c++) {
          f.column[std::size_t(c)] =
              a.column[std::size_t(c)] * std::sin(angle) + b.column[std::size_t(c)] * (1 - std::cos(angle));
          f.column[std::size_t(c)][c] += 1;
        }
        begin_viscous_step(kTwoThreads, model, state, step);
        deform(model, state, f);
        end_viscous_step(kTwoThreads, model, state, step);
        const Tensor s = stress_of_first(model, state);
        const auto power = [&](double now, double then, int r, int c) {
          return 0.5 * (now + then) * (strain(f, r, c) - strain(last, r, c)) * (r == c ? 1 : 2);
        };
        const double taken = power(s.xx, before.xx, 0, 0) + power(s.yy, before.yy, 1, 1) +
                             power(s.zz, before.zz, 2, 2) + power(s.xy, before.xy, 0, 1) +
                             power(s.xz, before.xz, 0, 2) + power(s.yz, before.yz, 1, 2);
        work += taken, scale += std::abs(taken);
        before = s, last = f;
      }
      EXPECT_GT(work, 0.01 * scale) << "loop " << loop;
    }
  }
}

// Steps that are undone leave the set and the displacements as they were, and the history to rounding.
TEST(LatticeViscosity, UndoneStepsKeepHistoryAndSet) {
  constexpr double kStep = 1.0 / 60;
  Model model = viscous_block(three_pairs(), 0.3);
  model.params.tissue.set = {.strain = 0.002, .share = 0.4, .time = 0.5};
  const Lattice& l = model.anatomy.lattice;
  // a block that is stretched by 2 %
  std::vector<NodeLoad> loads;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (const int i : {0, l.size.x - 1})
        loads.push_back({node_slot(l, {i, j, k}), {i == 0 ? -0.0015f : 0.0015f, 0, 0}});
  std::sort(loads.begin(), loads.end(), [](const NodeLoad& a, const NodeLoad& b) { return a.slot < b.slot; });
  State state = make_state(model);
  for (int n = 0; n < 10; n++) ASSERT_TRUE(step(kTwoThreads, model, state, {.loads = loads}, kStep).finite);
  ASSERT_GT(largest_set(kTwoThreads, model, state), 1e-4);
  const State before = state;
  // undone steps
  const NodeLoad endless[] = {{node_slot(l, {1, 1, 1}), {std::numeric_limits<Real>::infinity(), 0, 0}}};
  for (int n = 0; n < 5; n++) {
    EXPECT_FALSE(step(kTwoThreads, model, state, {.loads = endless}, kStep).finite);
    EXPECT_FALSE(state.viscosity.in_step);
  }
  EXPECT_EQ(largest_set(kTwoThreads, model, state), largest_set(kTwoThreads, model, before));
  const auto entries = [](const SymmetricField& field) {
    return std::vector{&field.xx, &field.yy, &field.zz, &field.xy, &field.xz, &field.yz};
  };
  ASSERT_EQ(state.viscosity.history.size(), 4U);
  double most = 0, error = 0;
  for (std::size_t p = 0; p < 4; p++)
    for (std::size_t e = 0; e < 6; e++)
      for (std::size_t s = 0; s < model.anatomy.cell_young.size(); s++) {
        const double now = double((*entries(state.viscosity.history[p])[e])[s]),
                     then = double((*entries(before.viscosity.history[p])[e])[s]);
        if (p == 3) {
          EXPECT_EQ(now, then) << "set";
        }
        most = std::max(most, std::abs(then)), error = std::max(error, std::abs(now - then));
      }
  EXPECT_GT(most, 0);
  EXPECT_LT(error, 1e-5 * most);
  for (std::size_t s = 0; s < model.anatomy.cell_young.size(); s++)
    if (model.anatomy.inverse_mass[s] > 0) {
      EXPECT_TRUE(state.motion.u[s] == before.motion.u[s]);
    }
}

// A viscous body needs six numbers a pair and slot, others none; the results do not depend on threads.
TEST(LatticeViscosity, MemoryAndThreads) {
  const Model model = viscous_block(three_pairs(), 0.3), elastic = viscous_block({}, 0.3);
  State one = make_state(model), two = make_state(model), none = make_state(elastic);
  std::vector<NodeLoad> loads = {{node_slot(model.anatomy.lattice, {3, 2, 2}), {0.01f, 0.02f, 0.005f}}};
  for (int n = 0; n < 5; n++) {
    step(Exec(1), model, one, {.loads = loads}, 1.0 / 60);
    step(Exec(4), model, two, {.loads = loads}, 1.0 / 60);
    step(Exec(1), elastic, none, {.loads = loads}, 1.0 / 60);
  }
  EXPECT_EQ(state_hash(model, one), state_hash(model, two));
  EXPECT_EQ(one.viscosity.history.size(), 3u);
  EXPECT_EQ(one.viscosity.history[2].yz.size() * sizeof(Real) * 6, 24 * model.anatomy.cell_young.size());
  EXPECT_TRUE(none.viscosity.history.empty());
}

}  // namespace
}  // namespace turgor::lattice
