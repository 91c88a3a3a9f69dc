// Bodies of solid cells in motion: under weight, at large strains, turned inside out and cut.
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
  const Int3 size = model.lattice.size;
  double sum = 0;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++) sum += u({size.x - 1, j, k});
  return sum / (size.y * size.z);
}

double settled_end(const Model& model, const Inputs& inputs, double rate, double seconds, int axis) {
  State state = make_state(model);
  for (int n = 0; n < seconds * rate; n++) step(Exec(2), model, state, inputs, 1 / rate);
  return mean_of_end(model,
                     [&](Int3 p) { return double(state.u[std::size_t(node_slot(model.lattice, p))][axis]); });
}

/// The same for small displacements, solved directly.
double linear_end(const Model& model, Vec3d gravity, int axis) {
  const Int3 size = model.lattice.size;
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
        const double w = double(model.inverse_mass[std::size_t(node_slot(model.lattice, a))]);
        for (int r = 0; r < 3; r++) {
          weight[3 * index(a) + r] = w > 0 ? gravity[r] / w : 0;
          if (w == 0) entries.emplace_back(3 * index(a) + r, 3 * index(a) + r, 1e12);  // held
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

TEST(lattice_cells, a_held_bar_sags_by_its_weight_whatever_the_sweeps_the_frame_rate_and_the_direction) {
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

TEST(lattice_cells, a_slender_bar_sags_as_a_beam_with_shear_does) {
  const Int3 size{31, 6, 6};
  for (const double poisson : {0.3, 0.45}) {
    const Model model = cantilever(5, poisson, size);
    const double h = 0.004, length = 30 * h, area = 25 * h * h, inertia = std::pow(5 * h, 4) / 12;
    const double weight = 9.81 * 1000 * 36 * h * h;  // N/m: nodes weigh a whole cell each
    const double shape = 10 * (1 + poisson) / (12 + 11 * poisson), shear = 2e5 / (2 * (1 + poisson));
    const double beyond = weight * h / 2;  // N: what the last nodes weigh beyond the bar's end
    const double beam = (weight * length / 8 + beyond / 3) * std::pow(length, 3) / (2e5 * inertia) +
                        (weight * length / 2 + beyond) * length / (shape * shear * area);
    const double found = -linear_end(model, {0, 0, -9.81}, 2);
    std::printf("v %.2f: %.2f mm, a beam %.2f mm\n", poisson, found * 1e3, beam * 1e3);
    EXPECT_NEAR(found, beam, 0.03 * beam) << "m, v " << poisson;
  }
}

TEST(lattice_cells, gravity_bends_a_bar_as_the_same_weight_on_every_node_does) {
  const Model model = cantilever(5, 0.3, {21, 6, 6});
  std::vector<NodeLoad> loads;
  for (std::size_t s = 0; s < model.inverse_mass.size(); s++)
    if (const Real w = model.inverse_mass[s]; w > 0) loads.push_back({int(s), {0, 0, Real(-9.81) / w}});
  const double weight = settled_end(model, {.gravity = {0, 0, -9.81}}, 60, 8, 2);
  EXPECT_LT(weight, -5e-3) << "m: far from small";
  EXPECT_NEAR(weight, settled_end(model, {.loads = loads}, 60, 8, 2), 0.001 * std::abs(weight));
}

TEST(lattice_cells, few_sweeps_of_nearly_incompressible_tissue_never_blow_up) {
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

/// A block with a stair on its top, so that it has whole cells, and edges that no whole cell holds.
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

/// A displacement that looks random, up to `size` along each axis [m].
void scatter(const Model& model, State& state, double size) {
  std::uint32_t seed = 7;
  const auto next = [&] {
    seed = seed * 1664525u + 1013904223u;
    return Real(size * (double(seed >> 8) / double(1 << 23) - 1));
  };
  for (int k = 0; k < model.lattice.size.z; k++)
    for (int j = 0; j < model.lattice.size.y; j++)
      for (int i = 0; i < model.lattice.size.x; i++) {
        const auto slot = std::size_t(node_slot(model.lattice, i, j, k));
        if (model.inverse_mass[slot] > 0) state.u.set(slot, {next(), next(), next()});
      }
}

TEST(lattice_cells, what_is_turned_inside_out_comes_back) {
  for (const double poisson : {0.3, 0.45}) {
    const Block block{
        .size = {7, 6, 7}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.z == 0; }};
    const Model model = block_model(block, solid_params(10, poisson));
    State state = make_state(model);
    scatter(model, state, 0.012);  // three steps, either way
    EXPECT_GT(energy(kOne, model, state), 1e-2) << "J";
    for (int n = 0; n < 600; n++) EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
    double farthest = 0;
    for (std::size_t s = 0; s < model.inverse_mass.size(); s++)
      if (model.inverse_mass[s] > 0) farthest = std::max(farthest, double(norm(state.u[s])));
    EXPECT_LT(farthest, 1e-5) << "m, v " << poisson << "; left over " << energy(kOne, model, state) << " J";
  }
}

TEST(lattice_cells, what_is_shot_off_its_holds_comes_back_whatever_the_sweeps) {
  for (const int sweeps : {2, 5, 20}) {
    const Block block{
        .size = {7, 6, 7}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.z == 0; }};
    const Model model = block_model(block, solid_params(sweeps, 0.45));
    State state = make_state(model);
    const Vec3 shot{3, 0, 8};  // m/s, 36 steps in a frame
    for (std::size_t s = 0; s < model.inverse_mass.size(); s++)
      if (model.inverse_mass[s] > 0) state.v.set(s, shot);
    state.fastest = norm(shot);
    double worst = 0, farthest = 0;
    for (int n = 0; n < 180; n++) {
      EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
      farthest = 0;
      for (std::size_t s = 0; s < model.inverse_mass.size(); s++)
        farthest = std::max(farthest, double(norm(state.u[s])));
      worst = std::max(worst, farthest);
    }
    EXPECT_LT(worst, 0.2) << "m, " << sweeps << " sweeps: little more than one frame of it";
    EXPECT_LT(farthest, 0.001) << "m after three seconds, " << sweeps << " sweeps";
  }
}

TEST(lattice_cells, the_residual_is_the_gradient_of_the_step_energy_of_cells_springs_and_cuts) {
  const Model model = stepped_block(0.45, 5);
  for (const bool cut : {false, true})
    for (const Int3 node : {Int3{3, 3, 3}, {2, 1, 7}, {4, 4, 6}, {8, 7, 6}}) {
      State state = make_state(model);
      if (cut) {
        for (std::size_t s = 0; s < state.cut.size(); s += 5) state.cut[s] = 0x15;
        std::fill(state.row_cut.begin(), state.row_cut.end(), std::uint8_t(1));
      }
      const auto slot = std::size_t(node_slot(model.lattice, node));
      Model alone = model;  // of which one node moves
      for (std::size_t s = 0; s < alone.inverse_mass.size(); s++)
        if (s != slot) alone.inverse_mass[s] = 0;
      alone.free_nodes = 1;
      if (!(model.inverse_mass[slot] > 0)) continue;  // no body here
      scatter(model, state, 0.002);
      state.u_before = state.u;
      Vec3d gradient;
      const Vec3 place = state.u[slot];
      for (int axis = 0; axis < 3; axis++) {
        double energies[2];
        for (const int side : {0, 1}) {
          Vec3 moved = place;
          moved[axis] += (side ? 1 : -1) * 1e-5f;
          state.u.set(slot, moved);
          energies[side] = step_energy(kOne, alone, state, {}, kDt);
        }
        gradient[axis] = (energies[1] - energies[0]) / 2e-5;
      }
      state.u.set(slot, place);
      EXPECT_NEAR(measure_residual(kOne, alone, state, {}, kDt).largest, norm(gradient),
                  0.005 * norm(gradient))
          << "N at " << node.x << node.y << node.z << (cut ? ", cut" : "");
    }
}

TEST(lattice_cells, descent_never_raises_the_energy_of_its_step) {
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

TEST(lattice_cells, the_rest_state_is_a_fixed_point) {
  const Model model = stepped_block(0.49, 5);
  State state = make_state(model);
  EXPECT_LT(step(kOne, model, state, {}, kDt).largest_speed, 1e-6) << "m/s";
}

TEST(lattice_cells, equal_bits_on_1_2_and_8_threads_and_again_with_a_cut) {
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

TEST(lattice_cells, a_cell_with_a_cut_edge_carries_nothing_across_and_no_node_hangs_on_nothing) {
  // A bar cut through between two planes of nodes: its far part is not pulled by its near one, and holds
  // together.
  const Block block{.size = {9, 4, 4}, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) {
                      return p.x == 0 || p.x == 8;
                    }};
  const Model model = block_model(block, solid_params(40, 0.3));
  State state = make_state(model);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 4; j++)
      for (int f = 0; f < kFamilyCount; f++)
        if (kFamilies[std::size_t(f)].x == 1)
          state.cut[std::size_t(node_slot(model.lattice, 4, j, k))] |= std::uint8_t(1u << f);
  std::fill(state.row_cut.begin(), state.row_cut.end(), std::uint8_t(1));
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 4; j++) state.u.set(std::size_t(node_slot(model.lattice, 8, j, k)), {0.004f, 0, 0});
  for (int n = 0; n < 120; n++) EXPECT_TRUE(step(kOne, model, state, {}, kDt).finite);
  for (int i = 1; i < 8; i++)
    EXPECT_NEAR(state.u[std::size_t(node_slot(model.lattice, i, 1, 2))].x, i <= 4 ? 0.0 : 0.004, 1e-5)
        << "m, layer " << i;
}

/// The largest gape of one straight cut through tense skin, settled [m].
double gape(const TissueParams& tissue, int sweeps) {
  constexpr int kN = 33;
  constexpr double kStep = 0.004;
  Block block{.size = {kN, kN, 9}, .step = kStep, .young = 5e3};
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

TEST(lattice_cells, a_wound_opens_about_as_far_as_in_springs_that_keep_their_volume_whatever_the_sweeps) {
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
