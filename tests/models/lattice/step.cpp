#include <Eigen/SparseCholesky>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/rows.hpp"
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

// ------------------------------------------------------------ forces from outside

/// Mass of a node: a cell of tissue at 0 HU [kg].
double node_mass(double step) { return 1000 * step * step * step; }

// A loaded free node accelerates by its force over its mass.
TEST(LatticeStep, LoadedNodeAcceleratesByForceOverMass) {
  for (const Method method : {Method::kPbd, Method::kVbd}) {
    Params params;
    params.skin.enabled = false;
    params.solver = {.method = method, .damping = 0};
    const Int3 size{9, 8, 7};
    const Model model =
        block_model({.size = size, .young = 1e-6, .skin_on_top = false}, params);  // nearly no stiffness
    State state = make_state(model);
    const int slot = node_slot(model.anatomy.lattice, 4, 3, 3);
    for (std::size_t edge = 0; edge < state.cuts.cut.size(); edge++)
      state.cuts.cut[edge] = 0x7f;  // isolates every node
    std::fill(state.cuts.row_cut.begin(), state.cuts.row_cut.end(), std::uint8_t(1));
    const Vec3 force{1e-5f, -2e-5f, 4e-5f};
    const NodeLoad loads[] = {{slot, force * 0.75f}, {slot, force * 0.25f}};  // loads on one node are summed
    step(kOne, model, state, {.loads = loads}, kDt);
    const Vec3d expected = Vec3d(force) * (kDt / node_mass(0.004));
    const Vec3d found(state.motion.v[std::size_t(slot)]);
    EXPECT_LT(norm(found - expected), 1e-5 * norm(expected)) << "m/s, method " << int(method);
    EXPECT_EQ(norm(state.motion.v[std::size_t(node_slot(model.anatomy.lattice, 5, 3, 3))]), 0)
        << "its neighbor";
  }
}

// Loads change the momentum by their sum; balanced loads do not change it.
TEST(LatticeStep, LoadsChangeMomentumByTheirSum) {
  Params params;
  params.skin.enabled = false;
  params.tissue.volume = 1;
  params.solver = {.sweeps = 200, .damping = 0};  // VBD conserves momentum when it has converged
  const Int3 size{9, 8, 7};
  const Model model = block_model({.size = size, .young = 20, .skin_on_top = false},
                                  params);  // soft, so that sweeps reach the whole body soon
  const auto slot = [&](Int3 p) { return node_slot(model.anatomy.lattice, p); };
  const std::vector<NodeLoad> balanced = {{slot({0, 0, 0}), {1e-5f, 2e-5f, 0}},
                                          {slot({8, 7, 6}), {1e-5f, -5e-5f, 0}},
                                          {slot({4, 4, 3}), {-2e-5f, 3e-5f, 0}}};
  std::vector<NodeLoad> more = balanced;
  more.push_back({slot({2, 2, 2}), {0, 0, 3e-5f}});
  for (const auto& [loads, sum] : {std::pair{balanced, Vec3d{}}, std::pair{more, Vec3d{0, 0, 3e-5}}}) {
    State state = make_state(model);
    for (int n = 0; n < 5; n++) step(kOne, model, state, {.loads = loads}, kDt);
    Vec3d momentum;
    for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
      if (model.anatomy.inverse_mass[s] > 0)
        momentum += Vec3d(state.motion.v[s]) / double(model.anatomy.inverse_mass[s]);
    EXPECT_LT(norm(momentum - sum * (5 * kDt)), 0.01 * 3e-5 * 5 * kDt) << momentum.z << " kg m/s";
  }
}

// A clamped bar under an end load stretches by Hooke's law.
TEST(LatticeStep, LoadedBarFollowsHooke) {
  const Int3 size{61, 9, 9};
  Params params;
  params.skin.enabled = false;
  params.solver = {.sweeps = 40, .damping = 8};
  const Block block{
      .size = size, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }};
  const Model model = block_model(block, params);
  const double area = size.y * size.z * 0.004 * 0.004, length = (size.x - 1) * 0.004,
               force = 1e4 * area * 0.01;
  std::vector<NodeLoad> loads;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      loads.push_back(
          {node_slot(model.anatomy.lattice, size.x - 1, j, k), {Real(force / (size.y * size.z)), 0, 0}});
  State state = make_state(model);
  for (int n = 0; n < 300; n++) step(Exec(2), model, state, {.loads = loads}, kDt);
  double stretch = 0;
  for (const NodeLoad& load : loads)
    stretch += double(state.motion.u[std::size_t(load.slot)].x) / double(loads.size());
  EXPECT_NEAR(stretch, force * length / (1e4 * area), 0.1 * 0.01 * length) << "m, F L / (E A)";
  const Residual residual = measure_residual(kOne, model, state, {.loads = loads}, kDt);
  EXPECT_LT(state.motion.v[std::size_t(loads[0].slot)].x, 1e-3)
      << "at rest; residual " << residual.largest << " N";
}

// ------------------------------------------------------------ weight

/// A bar along x, fixed at its left end.
Model cantilever(int sweeps, Int3 size) {
  Params params;
  params.skin.enabled = false;
  params.solver = {.sweeps = sweeps, .damping = 8};
  return block_model(
      {.size = size, .young = 2e5, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }},
      params);
}

/// Mean displacement of the right end along an axis after `seconds` [m].
double settled_end(const Model& model, const Inputs& inputs, double rate, double seconds, int axis) {
  State state = make_state(model);
  for (int n = 0; n < seconds * rate; n++) step(Exec(2), model, state, inputs, 1 / rate);
  const Int3 size = model.anatomy.lattice.size;
  double sum = 0;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      sum += double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, size.x - 1, j, k))][axis]);
  return sum / (size.y * size.z);
}

/// The same by the stiffness matrix of the springs for small displacements, solved directly.
double linear_end(const Model& model, Vec3d gravity, int axis) {
  const Lattice& l = model.anatomy.lattice;
  const auto index = [&](Int3 p) { return 3 * (p.x + l.size.x * (p.y + l.size.y * p.z)); };
  std::vector<Eigen::Triplet<double>> entries;
  const int count = 3 * l.size.x * l.size.y * l.size.z;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(count);
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 a{i, j, k};
        const auto slot = std::size_t(node_slot(l, a));
        const double w = double(model.anatomy.inverse_mass[slot]),
                     root = double(model.springs.root_stiffness[slot]);
        for (int r = 0; r < 3; r++) {
          weight[index(a) + r] = w > 0 ? gravity[r] / w : 0;
          if (w == 0) entries.emplace_back(index(a) + r, index(a) + r, 1e12);  // fixed
        }
        for (std::size_t f = 0; f < kFamilyCount; f++) {
          const Int3 b = a + kFamilies[f];
          if (!contains(l, b)) continue;
          const Vec3d n = normalized(Vec3d(rest_position(l, b) - rest_position(l, a)));
          const double stiffness = double(model.springs.scale[f]) * root *
                                   double(model.springs.root_stiffness[std::size_t(node_slot(l, b))]);
          for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
              for (const auto& [p, q, sign] : {std::tuple{a, a, 1}, {b, b, 1}, {a, b, -1}, {b, a, -1}})
                entries.emplace_back(index(p) + r, index(q) + c, sign * stiffness * n[r] * n[c]);
        }
      }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(weight);
  double sum = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++) sum += u[index({l.size.x - 1, j, k}) + axis];
  return sum / (l.size.y * l.size.z);
}

// A cantilever sags by its weight for any number of sweeps, frame rate and direction.
TEST(LatticeStep, BarSagIndependentOfSolver) {
  struct Case {
    int axis, sweeps;
    double rate, seconds;
  };
  for (const auto& [axis, sweeps, rate, seconds] :
       {Case{2, 5, 30, 25}, {2, 5, 60, 8}, {2, 20, 60, 3}, {2, 5, 120, 4}, {1, 5, 60, 8}, {0, 5, 60, 4}}) {
    const Model model = cantilever(sweeps, {15, 5, 6});
    Vec3d gravity;
    gravity[axis] = -9.81;
    const double expected = linear_end(model, gravity, axis);
    EXPECT_NEAR(settled_end(model, {.gravity = gravity}, rate, seconds, axis), expected,
                0.03 * std::abs(expected))
        << "m along axis " << axis << ", " << sweeps << " sweeps at " << rate << " Hz";
  }
}

// Gravity bends a bar as equal loads on its nodes do.
TEST(LatticeStep, GravityEqualsNodalLoads) {
  const Model model = cantilever(5, {25, 6, 6});
  std::vector<NodeLoad> loads;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const Real w = model.anatomy.inverse_mass[s]; w > 0)
      loads.push_back({int(s), {0, 0, Real(-9.81) / w}});
  const double weight = settled_end(model, {.gravity = {0, 0, -9.81}}, 60, 8, 2);
  EXPECT_LT(weight, -5e-3) << "m: a large displacement";
  EXPECT_NEAR(weight, settled_end(model, {.loads = loads}, 60, 8, 2), 0.001 * std::abs(weight));
}

// A free body is in free fall for any number of sweeps.
TEST(LatticeStep, FreeBodyFallsFreely) {
  for (const int sweeps : {1, 5, 40}) {
    Params params;
    params.skin.enabled = false;
    params.solver = {.sweeps = sweeps, .damping = 0};
    const Model model = block_model({.size = {9, 8, 7}, .young = 2e5, .skin_on_top = false}, params);
    State state = make_state(model);
    for (int n = 0; n < 30; n++) step(kOne, model, state, {.gravity = {3, 0, -9.81}}, kDt);
    const Vec3 v = state.motion.v[std::size_t(node_slot(model.anatomy.lattice, 4, 3, 3))];
    EXPECT_NEAR(v.z, -9.81 * 30 * kDt, 1e-3) << "m/s, " << sweeps << " sweeps";
    EXPECT_NEAR(v.x, 3 * 30 * kDt, 1e-3);
  }
}

// ------------------------------------------------------------ the schedule

// No two slabs of a phase share a node.
TEST(LatticeStep, SlabsOfPhaseShareNoNodes) {
  for (const int layers : {2, 3, 7, 12}) {
    for (int phase = 0; phase < 2; phase++) {
      std::set<int> touched;
      for (int slab = phase; slab < slab_count({0, layers}); slab += 2) {
        std::set<int> nodes;  // layers that the slab writes: its own and, for edges and cells, the next one
        for (int k = slab * kSlabLayers; k < (slab + 1) * kSlabLayers && k < layers; k++)
          nodes.insert({k, k + 1});
        for (const int k : nodes) EXPECT_TRUE(touched.insert(k).second) << "layer " << k << " of " << layers;
      }
    }
  }
}

// No two lanes of a row pass share a node.
TEST(LatticeStep, LanesOfRowPassShareNoNodes) {
  for (const int nx : {2, 3, 8, 9, 33}) {
    const Lattice l = make_lattice({nx, 4, 4}, {1, 1, 1});
    for (const auto& family : kFamilies)
      for (int parity = 0; parity < 2; parity++) {
        std::set<int> slots;
        const int a = row_slot(l, 1, 1) + parity * l.half, b = a + slot_offset(l, family, parity);
        for (int i = 0; i < half_count(l, parity); i++) {
          EXPECT_TRUE(slots.insert(a + i).second);
          EXPECT_TRUE(slots.insert(b + i).second) << "family " << family.x << family.y << family.z;
        }
      }
    for (const auto& tet : kKuhnTets)
      for (int parity = 0; parity < 2; parity++) {
        std::set<int> slots;
        for (const Int3 corner : tet)
          for (int i = 0; i < half_count(l, parity); i++)
            EXPECT_TRUE(slots.insert(row_slot(l, 1, 1) + parity * l.half + slot_offset(l, corner, parity) + i)
                            .second);
      }
  }
}

}  // namespace
}  // namespace turgor::lattice
