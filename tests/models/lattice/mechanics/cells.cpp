// Bodies of solid cells in motion: under their weight, at large strains, inverted and cut.
#include <cmath>
#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/cell_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

// ------------------------------------------------------------ weight

Params solid_params(int sweeps, double poisson) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.poisson = poisson;
  params.solver = {.sweeps = sweeps, .damping = 8};
  return params;
}

Model cantilever(int sweeps, double poisson, Int3 size) {
  return block_model(
      {.size = size, .young = 2e5, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }},
      solid_params(sweeps, poisson));
}

double mean_of_end(const Model& model, const std::function<double(Int3)>& u) {
  const Int3 size = model.anatomy.lattice.size;
  double sum = 0;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++) sum += u({size.x - 1, j, k});
  return sum / (size.y * size.z);
}

double settled_end(const Model& model, const Inputs& inputs, double rate, double seconds, int axis) {
  State state = make_state(model);
  for (int n = 0; n < seconds * rate; n++) step(Exec(2), model, state, inputs, 1 / rate);
  return mean_of_end(model, [&](Int3 p) {
    return double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, p))][axis]);
  });
}

/// The same for small displacements, solved directly.
double linear_end(const Model& model, Vec3d gravity, int axis) {
  const Int3 size = model.anatomy.lattice.size;
  const auto index = [&](Int3 p) { return p.x + size.x * (p.y + size.y * p.z); };
  CellBody body{0.004, {}, {}};
  const CellMatrix matrix = solid_matrix(0.004, model.params.tissue.poisson) * 2e5;
  std::vector<Eigen::Triplet<double>> entries;
  const int count = 3 * size.x * size.y * size.z;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(count);
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Int3 a{i, j, k};
        const double w = double(model.anatomy.inverse_mass[std::size_t(node_slot(model.anatomy.lattice, a))]);
        for (int r = 0; r < 3; r++) {
          weight[3 * index(a) + r] = w > 0 ? gravity[r] / w : 0;
          if (w == 0) entries.emplace_back(3 * index(a) + r, 3 * index(a) + r, 1e12);  // fixed
        }
        if (i + 1 == size.x || j + 1 == size.y || k + 1 == size.z) continue;
        for (int p = 0; p < 24; p++)
          for (int q = 0; q < 24; q++)
            entries.emplace_back(3 * index(a + cell_corner(p / 3)) + p % 3,
                                 3 * index(a + cell_corner(q / 3)) + q % 3, matrix(p, q));
      }
  Eigen::SparseMatrix<double> k(count, count);
  k.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(k).solve(weight);
  return mean_of_end(model, [&](Int3 p) { return u[3 * index(p) + axis]; });
}

// A cantilever sags by its weight for any number of sweeps, frame rate and direction.
TEST(LatticeCells, BarSagIndependentOfSolver) {
  struct Case {
    int axis, sweeps;
    double rate, seconds, poisson;
  };
  for (const auto& [axis, sweeps, rate, seconds, poisson] : {Case{2, 5, 30, 14, 0.3},
                                                             {2, 5, 60, 5, 0.3},
                                                             {2, 5, 120, 3, 0.3},
                                                             {1, 5, 60, 5, 0.3},
                                                             {2, 10, 60, 5, 0.45},
                                                             {2, 20, 120, 3, 0.45}}) {
    const Model model = cantilever(sweeps, poisson, {15, 5, 6});
    Vec3d gravity;
    gravity[axis] = -9.81;
    const double expected = linear_end(model, gravity, axis);
    EXPECT_NEAR(settled_end(model, {.gravity = gravity}, rate, seconds, axis), expected,
                0.03 * std::abs(expected))
        << "m along axis " << axis << ", v " << poisson << ", " << sweeps << " sweeps at " << rate << " Hz";
  }
}

// A slender bar sags as a Timoshenko beam.
TEST(LatticeCells, SlenderBarMatchesTimoshenko) {
  const Int3 size{31, 6, 6};
  for (const double poisson : {0.3, 0.45}) {
    const Model model = cantilever(5, poisson, size);
    const double h = 0.004, length = 30 * h, area = 25 * h * h, inertia = std::pow(5 * h, 4) / 12;
    const double weight = 9.81 * 1000 * 36 * h * h;  // N/m: every node has the mass of a whole cell
    const double shape = 10 * (1 + poisson) / (12 + 11 * poisson), shear = 2e5 / (2 * (1 + poisson));
    const double beyond = weight * h / 2;  // N: weight of the last nodes beyond the bar's end
    const double beam = (weight * length / 8 + beyond / 3) * std::pow(length, 3) / (2e5 * inertia) +
                        (weight * length / 2 + beyond) * length / (shape * shear * area);
    const double found = -linear_end(model, {0, 0, -9.81}, 2);
    std::printf("v %.2f: %.2f mm, a beam %.2f mm\n", poisson, found * 1e3, beam * 1e3);
    EXPECT_NEAR(found, beam, 0.03 * beam) << "m, v " << poisson;
  }
}

// Gravity bends a bar as equal loads on its nodes do.
TEST(LatticeCells, GravityEqualsNodalLoads) {
  const Model model = cantilever(5, 0.3, {21, 6, 6});
  std::vector<NodeLoad> loads;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const Real w = model.anatomy.inverse_mass[s]; w > 0)
      loads.push_back({int(s), {0, 0, Real(-9.81) / w}});
  const double weight = settled_end(model, {.gravity = {0, 0, -9.81}}, 60, 8, 2);
  EXPECT_LT(weight, -5e-3) << "m: a large displacement";
  EXPECT_NEAR(weight, settled_end(model, {.loads = loads}, 60, 8, 2), 0.001 * std::abs(weight));
}

// Few sweeps of nearly incompressible tissue are stable.
TEST(LatticeCells, FewSweepsAreStable) {
  for (const double poisson : {0.45, 0.49})
    for (const int sweeps : {2, 3, 4, 5, 7}) {
      const Model model = cantilever(sweeps, poisson, {15, 5, 6});
      const double sag = linear_end(model, {0, 0, -9.81}, 2),
                   end = settled_end(model, {.gravity = {0, 0, -9.81}}, 60, 6, 2);
      EXPECT_LT(end, 0) << "m, v " << poisson << ", " << sweeps << " sweeps";
      EXPECT_GT(end, 1.1 * sag) << "m, v " << poisson << ", " << sweeps << " sweeps";
    }
}

// ------------------------------------------------------------ large strains

/// A block with a step on its top, so that it has whole cells and also edges outside of whole cells.
Model stepped_block(double poisson, int sweeps, bool skin = false) {
  const Int3 size{9, 8, 8};
  Block block{.size = size, .young = 1e4, .skin_on_top = true, .is_fixed = [](Int3 p) { return p.z == 0; }};
  BodyNodes nodes = block_nodes(block);
  for (int j = 0; j < size.y; j++)
    for (int i = 0; i < size.x; i++)
      if (i + j > 6 || (i + 2 * j) % 3 == 0) {
        const std::size_t n = sample_index(nodes.grid, i, j, size.z - 1);
        nodes.tissue[n] = Tissue::kOutside, nodes.hu[n] = kAirHu, nodes.young[n] = 0;
      }
  Params params = solid_params(sweeps, poisson);
  params.skin.enabled = skin;
  return assemble(kOne, nodes, nullptr, params).value();
}

/// A pseudorandom displacement of up to `size` along each axis [m].
void scatter(const Model& model, State& state, double size) {
  std::uint32_t seed = 7;
  const auto next = [&] {
    seed = seed * 1664525u + 1013904223u;
    return Real(size * (double(seed >> 8) / double(1 << 23) - 1));
  };
  for (int k = 0; k < model.anatomy.lattice.size.z; k++)
    for (int j = 0; j < model.anatomy.lattice.size.y; j++)
      for (int i = 0; i < model.anatomy.lattice.size.x; i++) {
        const auto slot = std::size_t(node_slot(model.anatomy.lattice, i, j, k));
        if (model.anatomy.inverse_mass[slot] > 0) state.motion.u.set(slot, {next(), next(), next()});
      }
}

// Inverted cells recover the rest shape.
TEST(LatticeCells, InvertedCellsRecover) {
  for (const double poisson : {0.3, 0.45}) {
    const Block block{
        .size = {7, 6, 7}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.z == 0; }};
    const Model model = block_model(block, solid_params(10, poisson));
    State state = make_state(model);
    scatter(model, state, 0.012);  // three cells in either direction
    EXPECT_GT(energy(kOne, model, state), 1e-2) << "J";
    for (int n = 0; n < 600; n++) EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
    double farthest = 0;
    for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
      if (model.anatomy.inverse_mass[s] > 0) farthest = std::max(farthest, double(norm(state.motion.u[s])));
    EXPECT_LT(farthest, 1e-5) << "m, v " << poisson << "; remaining energy " << energy(kOne, model, state)
                              << " J";
  }
}

// A body that is launched from its fixed nodes returns to rest for any number of sweeps.
TEST(LatticeCells, FastBodyReturnsToRest) {
  for (const int sweeps : {2, 5, 20}) {
    const Block block{
        .size = {7, 6, 7}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.z == 0; }};
    const Model model = block_model(block, solid_params(sweeps, 0.45));
    State state = make_state(model);
    const Vec3 shot{3, 0, 8};  // m/s, 36 cells per frame
    for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
      if (model.anatomy.inverse_mass[s] > 0) state.motion.v.set(s, shot);
    state.motion.fastest = norm(shot);
    double worst = 0, farthest = 0;
    for (int n = 0; n < 180; n++) {
      EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
      farthest = 0;
      for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
        farthest = std::max(farthest, double(norm(state.motion.u[s])));
      worst = std::max(worst, farthest);
    }
    EXPECT_LT(worst, 0.2) << "m, " << sweeps << " sweeps: little more than the motion of one frame";
    EXPECT_LT(farthest, 0.001) << "m after three seconds, " << sweeps << " sweeps";
  }
}

// The residual is the gradient of the step energy for cells, springs and cuts.
TEST(LatticeCells, ResidualIsEnergyGradient) {
  const Model model = stepped_block(0.45, 5);
  for (const bool cut : {false, true})
    for (const Int3 node : {Int3{3, 3, 3}, {2, 1, 7}, {4, 4, 6}, {8, 7, 6}}) {
      State state = make_state(model);
      if (cut) {
        for (std::size_t s = 0; s < state.cuts.cut.size(); s += 5) state.cuts.cut[s] = 0x15;
        std::fill(state.cuts.row_cut.begin(), state.cuts.row_cut.end(), std::uint8_t(1));
      }
      const auto slot = std::size_t(node_slot(model.anatomy.lattice, node));
      Model alone = model;  // only one node may move
      for (std::size_t s = 0; s < alone.anatomy.inverse_mass.size(); s++)
        if (s != slot) alone.anatomy.inverse_mass[s] = 0;
      alone.anatomy.free_nodes = 1;
      if (!(model.anatomy.inverse_mass[slot] > 0)) continue;  // not a free node
      scatter(model, state, 0.002);
      state.motion.u_before = state.motion.u;
      Vec3d gradient;
      const Vec3 position = state.motion.u[slot];
      for (int axis = 0; axis < 3; axis++) {
        double energies[2];
        for (const int side : {0, 1}) {
          Vec3 moved = position;
          moved[axis] += (side ? 1 : -1) * 1e-5f;
          state.motion.u.set(slot, moved);
          energies[side] = step_energy(kOne, alone, state, {}, kDt);
        }
        gradient[axis] = (energies[1] - energies[0]) / 2e-5;
      }
      state.motion.u.set(slot, position);
      EXPECT_NEAR(measure_residual(kOne, alone, state, {}, kDt).largest, norm(gradient),
                  0.005 * norm(gradient))
          << "N at " << node.x << node.y << node.z << (cut ? ", cut" : "");
    }
}

// VBD sweeps never raise the energy of the step.
TEST(LatticeCells, VbdNeverRaisesEnergy) {
  for (const double poisson : {0.0, 0.49}) {
    const Model model = stepped_block(poisson, 5, true);
    State state = make_state(model);
    scatter(model, state, 0.002);
    const Inputs inputs{.gravity = {0, 0, -9.81}};
    predict(kOne, model, state, inputs, kDt);
    double before = step_energy(kOne, model, state, inputs, kDt);
    for (int sweep = 0; sweep < 20; sweep++) {
      sweep_vbd(kOne, model, state, inputs, kDt, sweep % 2 ? Order::kBackward : Order::kForward);
      const double after = step_energy(kOne, model, state, inputs, kDt);
      EXPECT_LE(after, before * (1 + 1e-6)) << "v " << poisson << ", sweep " << sweep;
      before = after;
    }
  }
}

// The rest state is a fixed point.
TEST(LatticeCells, RestStateIsFixedPoint) {
  const Model model = stepped_block(0.49, 5);
  State state = make_state(model);
  EXPECT_LT(step(kOne, model, state, {}, kDt).largest_speed, 1e-6) << "m/s";
}

// One, two and eight threads give the same bits, repeatedly and with a cut.
TEST(LatticeCells, EqualBitsOnAnyThreads) {
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8, 8}) {
    const Model model = stepped_block(0.45, 5, true);
    State state = make_state(model);
    scatter(model, state, 0.001);
    const BladePath path =
        lay_blade(model, state, {.from = {0.006, 0.014, 0.028}, .to = {0.026, 0.014, 0.028}}).value();
    EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 10);
    for (int n = 0; n < 5; n++) step(Exec(threads), model, state, {.gravity = {0, 0, -9.81}}, kDt);
    hashes.insert(state_hash(model, state));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

// A cell with cut edges transfers no force across the cut, and its nodes stay connected on either side.
TEST(LatticeCells, CutEdgesTransferNoForce) {
  // A bar is cut between two planes of nodes: its far half is not pulled by the near one and stays connected.
  const Block block{.size = {9, 4, 4}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) {
                      return p.x == 0 || p.x == 8;
                    }};
  const Model model = block_model(block, solid_params(40, 0.3));
  State state = make_state(model);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 4; j++)
      for (int f = 0; f < kFamilyCount; f++)
        if (kFamilies[std::size_t(f)].x == 1)
          state.cuts.cut[std::size_t(node_slot(model.anatomy.lattice, 4, j, k))] |= std::uint8_t(1u << f);
  std::fill(state.cuts.row_cut.begin(), state.cuts.row_cut.end(), std::uint8_t(1));
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 4; j++)
      state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, 8, j, k)), {0.004f, 0, 0});
  for (int n = 0; n < 120; n++) EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
  for (int i = 1; i < 8; i++)
    EXPECT_NEAR(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, i, 1, 2))].x,
                i <= 4 ? 0.0 : 0.004, 1e-5)
        << "m, layer " << i;
}

/// Largest gape at rest of a straight cut through tense skin [m].
double gape(const TissueParams& tissue, int sweeps) {
  constexpr int kN = 33;
  constexpr double kStep = 0.004;
  Block block{.size = {kN, kN, 9}, .spacing = kStep, .young = 5e3};
  block.is_fixed = [](Int3 p) { return p.z == 0 || p.x == 0 || p.y == 0 || p.x == kN - 1 || p.y == kN - 1; };
  Params params;
  params.tissue = tissue;
  params.solver = {.sweeps = sweeps, .damping = 4};
  const Model model = block_model(block, params);
  State state = make_state(model);
  const double y = 15.5 * kStep;
  const Incision incision{
      .from = {9.6 * kStep, y, 8 * kStep}, .to = {22.4 * kStep, y, 8 * kStep}, .depth = 2.4 * kStep};
  const BladePath path = lay_blade(model, state, incision).value();
  cut_edges(model, state, path, 0, 1, 0);
  for (int frame = 0; frame < 120; frame++) EXPECT_TRUE(step(Exec(2), model, state, {}, kDt).finite);
  return measure_wound(model, state, path, 0).gape_max;
}

// A wound gapes about as far as with springs and volume constraints, for any number of sweeps.
TEST(LatticeCells, WoundGapeNearsThatOfSprings) {
  const double springs = gape({.volume = 2}, 10);
  const TissueParams solid{.law = TissueLaw::kSolid, .poisson = 0.43};
  const double few = gape(solid, 5), many = gape(solid, 20);
  std::printf("springs %.2f mm; cells: 5 sweeps %.2f mm, 20 sweeps %.2f mm\n", springs * 1e3, few * 1e3,
              many * 1e3);
  EXPECT_NEAR(few, many, 0.03 * many) << "m";
  EXPECT_NEAR(many, springs, 0.3 * springs) << "m";
}

}  // namespace
}  // namespace turgor::lattice
