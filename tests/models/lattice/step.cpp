#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

bool is_border(Int3 p, Int3 size) {
  return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
}

/// A small tense block with fixed sides and prescribed displacements.
struct Pushed {
  Model model;
  State state;
};
Pushed pushed_block(Params params, double push = 1e-3) {
  const Int3 size{13, 11, 9};
  Block block{.size = size};
  block.is_fixed = [size](Int3 p) { return is_border(p, size); };
  Pushed p{block_model(block, params), {}};
  p.state = make_state(p.model);
  const auto wave = [&](int a, int b) { return Real(push * std::sin(1.3 * a + 0.7 * b)); };
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (!is_border({i, j, k}, size))
          p.state.motion.u.set(std::size_t(node_slot(p.model.anatomy.lattice, i, j, k)),
                               {wave(i, j), wave(j, k), wave(k, i)});
  return p;
}

// Without skin, the rest state is a fixed point of both solvers.
TEST(LatticeStep, RestStateIsFixedPoint) {
  for (const Method method : {Method::kPbd, Method::kVbd}) {
    Params params;
    params.skin.enabled = false;
    params.solver.method = method;
    params.solver.pbd_volume = true;
    params.tissue.volume = 2;
    const Model model = block_model({.size = {9, 8, 7}, .skin_on_top = false}, params);
    State state = make_state(model);
    const StepReport report = step(kOne, model, state, {}, kDt);
    EXPECT_LT(report.largest_speed, 1e-6) << "m/s, method " << int(method);
  }
}

constexpr Ordering kOrderings[] = {Ordering::kSlabs, Ordering::kColors};

// VBD sweeps never raise the energy of the step.
TEST(LatticeStep, VbdNeverRaisesEnergy) {
  for (const auto& [law, volume, ordering] : {std::tuple{SkinLaw::kArea, 0.0, Ordering::kSlabs},
                                              {SkinLaw::kArea, 5.0, Ordering::kSlabs},
                                              {SkinLaw::kFiber, 0.0, Ordering::kSlabs},
                                              {SkinLaw::kFiber, 5.0, Ordering::kSlabs},
                                              {SkinLaw::kArea, 5.0, Ordering::kColors},
                                              {SkinLaw::kFiber, 0.0, Ordering::kColors}}) {
    Params params;
    params.skin.law = law;
    params.tissue.volume = volume;
    params.solver.ordering = ordering;
    auto [model, state] = pushed_block(params, 2e-3);
    const Inputs inputs{.gravity = {0, 0, -9.81}};
    predict(kOne, model, state, inputs, kDt);
    double before = step_energy(kOne, model, state, inputs, kDt);
    for (int sweep = 0; sweep < 20; sweep++) {
      sweep_vbd(kOne, model, state, inputs, kDt);
      const double after = step_energy(kOne, model, state, inputs, kDt);
      EXPECT_LE(after, before * (1 + 1e-6)) << "law " << int(law) << ", volume " << volume << ", sweep "
                                            << sweep << ", ordering " << int(ordering);
      before = after;
    }
  }
}

// VBD converges to a vanishing residual.
TEST(LatticeStep, VbdConvergesToZeroResidual) {
  Params params;
  params.tissue.volume = 2;
  auto [model, state] = pushed_block(params);
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  predict(kOne, model, state, inputs, kDt);
  const double first = measure_residual(kOne, model, state, inputs, kDt).largest;
  for (int sweep = 0; sweep < 300; sweep++) sweep_vbd(kOne, model, state, inputs, kDt);
  EXPECT_LT(measure_residual(kOne, model, state, inputs, kDt).largest, 1e-3 * first);
}

// The residual is the gradient of the step energy.
TEST(LatticeStep, ResidualIsEnergyGradient) {
  Params params;
  params.tissue.volume = 3;
  auto [model, state] = pushed_block(params, 0);
  // One skin node is loaded and displaced; its force follows from energies alone.
  const auto slot = std::size_t(node_slot(model.anatomy.lattice, 6, 5, 8));
  const NodeLoad loads[] = {{int(slot), {2e-3f, 1e-3f, -3e-3f}}};
  const Inputs inputs{.gravity = {1, -2, -9.81}, .loads = loads};
  predict(kOne, model, state, inputs, kDt);
  for (int sweep = 0; sweep < 500; sweep++) sweep_vbd(kOne, model, state, inputs, kDt);
  const Vec3 pushed = state.motion.u[slot] + Vec3{4e-4f, -3e-4f, 5e-4f};
  Vec3d gradient;
  for (int axis = 0; axis < 3; axis++) {
    double energies[2];
    for (const int side : {0, 1}) {
      Vec3 position = pushed;
      position[axis] += (side ? 1 : -1) * 2e-5f;
      state.motion.u.set(slot, position);
      energies[side] = step_energy(kOne, model, state, inputs, kDt);
    }
    gradient[axis] = (energies[1] - energies[0]) / 4e-5;
  }
  state.motion.u.set(slot, pushed);
  const Residual residual = measure_residual(kOne, model, state, inputs, kDt);
  EXPECT_NEAR(residual.largest, norm(gradient), 0.01 * norm(gradient)) << "N";
}

/// The same with a cut, and with volume constraints.
Pushed cut_block(Method method, Ordering ordering) {
  Params params;
  params.solver = {.method = method, .ordering = ordering, .pbd_volume = true};
  params.tissue.volume = method == Method::kPbd ? 0 : 1;
  params.skin.law = method == Method::kPbd ? SkinLaw::kArea : SkinLaw::kFiber;
  Pushed block = pushed_block(params);
  const BladePath path =
      lay_blade(block.model, block.state, {.from = {0.015, 0.022, 0.032}, .to = {0.032, 0.022, 0.032}})
          .value();
  EXPECT_GT(cut_edges(block.model, block.state, path, 0, 1, 0), 10);
  return block;
}

// One, two and eight threads give the same bits, repeatedly.
TEST(LatticeStep, EqualBitsOnAnyThreads) {
  for (const Method method : {Method::kPbd, Method::kVbd})
    for (const Ordering ordering : kOrderings) {
      std::set<std::uint64_t> hashes;
      for (const int threads : {1, 2, 8, 8}) {
        auto [model, state] = cut_block(method, ordering);
        const NodeLoad loads[] = {{node_slot(model.anatomy.lattice, 5, 4, 8), {1e-3f, 0, -2e-3f}}};
        const Inputs inputs{.gravity = {0, 0, -9.81}, .loads = loads};
        for (int n = 0; n < 5; n++) step(Exec(threads), model, state, inputs, kDt);
        hashes.insert(state_hash(model, state));
      }
      EXPECT_EQ(hashes.size(), 1u) << "method " << int(method) << ", ordering " << int(ordering);
    }
}

// A step that is not finite is undone; the simulation continues.
TEST(LatticeStep, NonFiniteStepIsUndone) {
  for (const Method method : {Method::kVbd, Method::kPbd})
    for (const Ordering ordering : kOrderings) {
      auto [model, state] = cut_block(method, ordering);
      const State good = state;
      const Real* view = state.motion.u.x.data();
      const StepReport report = step(kOne, model, state, {.gravity = {0, 0, std::nan("")}}, kDt);
      EXPECT_FALSE(report.finite);
      EXPECT_EQ(state.motion.u.x, good.motion.u.x);
      EXPECT_EQ(state.motion.u.z, good.motion.u.z) << "also of fixed nodes";
      EXPECT_EQ(state.motion.u.x.data(), view) << "views stay valid";
      EXPECT_EQ(state.motion.time, good.motion.time);
      EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite) << "the simulation continues";
    }
}

// PBD conserves the momentum of a free body.
TEST(LatticeStep, PbdConservesMomentumOfFreeBody) {
  Params params;
  params.solver = {.method = Method::kPbd, .damping = 0, .pbd_volume = true};
  params.skin.enabled = false;
  const Model model = block_model({.size = {9, 8, 7}, .skin_on_top = false}, params);
  State state = make_state(model);
  for (int i = 0; i < 9; i++)
    state.motion.v.set(std::size_t(node_slot(model.anatomy.lattice, i, 3, 3)), {0.1f, -0.2f, 0.3f});
  const auto momentum = [&] {
    Vec3d sum;
    for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
      if (model.anatomy.inverse_mass[s] > 0)
        sum += Vec3d(state.motion.v[s]) / double(model.anatomy.inverse_mass[s]);
    return sum;
  };
  const Vec3d before = momentum();
  for (int n = 0; n < 10; n++) step(kOne, model, state, {}, kDt);
  for (int axis = 0; axis < 3; axis++) EXPECT_NEAR(momentum()[axis], before[axis], 1e-4 * norm(before));
}

}  // namespace
}  // namespace turgor::lattice
