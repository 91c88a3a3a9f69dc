// Cells and skin that a blade parted go on bearing what they bore, each side for itself.
#include "turgor/models/lattice/mechanics/cut_elements.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);

/// What a bar of 13 × 5 × 5 nodes stores, of ½ E A δ²/L, when its ends are held δ apart: cut through from end
/// to end by an upright blade `aside` steps from its side, at an angle to it; 0 = not at all.
double stored(double aside, double degrees) {
  constexpr double kStep = 0.004, kWay = 0.001, kLength = 12 * kStep, kYoung = 1e4;
  const Block block{
      .size = {13, 5, 5}, .young = kYoung, .is_fixed = [](Int3 p) { return p.x == 0 || p.x == 12; }};
  Params params = solid_params(20, 8, 1e-4);
  params.tissue.poisson = 0;
  params.skin.stiffness = params.skin.shear = 1e-3;
  const Model model = block_model(block, params);
  State state = make_state(model);
  if (aside > 0) {
    const double slope = std::tan(degrees * std::numbers::pi / 180), y = aside * kStep;
    const Incision blade{
        .from = {0, y, 4 * kStep}, .to = {kLength, y + slope * kLength, 4 * kStep}, .depth = 0.03};
    EXPECT_GT(cut_edges(model, state, lay_blade(model, state, blade).value(), 0, 1, 0), 40);
    EXPECT_GT(state.parts.virtual_nodes.size(), 50u);
  }
  for (int j = 0; j < 5; j++)
    for (int k = 0; k < 5; k++)
      state.u.set(std::size_t(node_slot(model.lattice, 12, j, k)), {Real(kWay), 0, 0});
  for (int n = 0; n < 100; n++) EXPECT_TRUE(step(kOne, model, state, {}, 1.0 / 60).finite);
  return energy(kOne, model, state) / (0.5 * kYoung * 16 * kStep * kStep * kWay * kWay / kLength);
}

/// Two bars side by side, of widths that go from a to b and from 4 − a to 4 − b: each is as stiff as the mean
/// of its compliance.
double of_tapered_bars(double a, double b) {
  const auto stiffness = [](double from, double to) {
    return std::abs(to - from) > 1e-6 ? (to - from) / std::log(to / from) : from;
  };
  return (stiffness(a, b) + stiffness(4 - a, 4 - b)) / 4;
}

TEST(lattice_parts, a_bar_that_is_split_along_its_length_is_as_stiff_as_both_its_parts) {
  EXPECT_NEAR(stored(0, 0), 1, 0.01) << "of E A/L";
  for (const double aside : {1.5, 1.7, 2.05, 3.9})
    EXPECT_NEAR(stored(aside, 0), 1, 0.01) << "cut " << aside << " steps aside";
  const double end = 0.6 + 12 * std::tan(10 * std::numbers::pi / 180);
  EXPECT_NEAR(stored(0.6, 10), of_tapered_bars(0.6, end), 0.05) << "cut aslant";
}

TEST(lattice_parts, a_wound_gapes_alike_wherever_its_blade_lies_in_the_cells_and_whichever_way) {
  Params params = solid_params(10, 4, 45);
  params.tissue.poisson = 0.45;
  double least = 1, most = 0;
  for (const auto& [aside, along, degrees] :
       {std::array{0.5, 0.5, 0.0}, {0.1, 0.25, 0.0}, {0.3, 0.0, 90.0}, {0.5, 0.5, 30.0}, {0.2, 0.5, 120.0}}) {
    Wounded wounded(aside, along, degrees, params);
    for (int n = 0; n < 75; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 30);
    const double gape = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
    std::printf("%.2f aside, %.2f along, %3.0f degrees: %.2f mm\n", aside, along, degrees, 1e3 * gape);
    least = std::min(least, gape), most = std::max(most, gape);
  }
  EXPECT_LT(most - least, 0.06 * most) << "m";
}

TEST(lattice_parts, forces_on_copies_are_the_gradient_of_the_energy) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const Model& model = wounded.model;
  State& state = wounded.state;
  scatter(model, state, 0.0005);
  const CutElementForces forces(model, state);
  ASSERT_GT(state.parts.virtual_nodes.size(), 20u);
  for (std::size_t n = 0; n < state.parts.virtual_nodes.size(); n += 7) {
    const ElementNode& node = state.parts.virtual_nodes[n];
    VirtualNodeShift& at = state.virtual_nodes[std::size_t(node.corner - slot_count(model.lattice))];
    const VirtualNodeShift place = at;
    const Vec3d force(forces.gather(node).f);
    Vec3d gradient;
    for (Real VirtualNodeShift::*axis : {&VirtualNodeShift::x, &VirtualNodeShift::y, &VirtualNodeShift::z}) {
      double energies[2];
      for (const int side : {0, 1}) {
        at = place;
        at.*axis += side ? 1e-5f : -1e-5f;
        energies[side] = energy(kOne, model, state);
      }
      at = place;
      gradient[axis == &VirtualNodeShift::x   ? 0
               : axis == &VirtualNodeShift::y ? 1
                                              : 2] = (energies[1] - energies[0]) / 2e-5;
    }
    EXPECT_LT(norm(gradient + force), 0.01 * norm(gradient) + 1e-6) << "N, copy " << n;
  }
}

TEST(lattice_parts, descent_never_raises_the_energy_of_a_step_with_a_wound) {
  for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
    Params params = solid_params(5, 4, 45);
    params.solver.ordering = ordering;
    Wounded wounded(0.3, 0.5, 20, params);
    scatter(wounded.model, wounded.state, 0.0005);
    predict(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    double before = step_energy(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    for (int sweep = 0; sweep < 10; sweep++) {
      sweep_vbd(kOne, wounded.model, wounded.state, {}, 1.0 / 60,
                sweep % 2 ? Order::kBackward : Order::kForward);
      const double after = step_energy(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
      EXPECT_LE(after, before * (1 + 1e-6)) << "J, sweep " << sweep << ", schedule " << int(ordering);
      before = after;
    }
  }
}

/// The nodes of one element; it would show were two of them of one colour, copies of a node as that node.
void expect_different_colors(const Wounded& wounded, std::span<const int> corners, const char* what) {
  const Lattice& l = wounded.model.lattice;
  std::set<int> colors;
  for (const int corner : corners) {
    int slot = corner;
    if (corner >= slot_count(l)) slot = wounded.state.parts.places[std::size_t(corner - slot_count(l))].first;
    EXPECT_TRUE(colors.insert(color_of(slot_node(l, slot))).second) << what << ", corner " << corner;
  }
}

TEST(lattice_parts, no_two_nodes_or_copies_of_a_color_share_a_cell_a_triangle_or_a_part_of_one) {
  for (const double degrees : {20.0, 75.0}) {
    const Wounded wounded(0.3, 0.5, degrees, solid_params(5, 4, 45));
    const Lattice& l = wounded.model.lattice;
    int whole = 0;
    for (std::size_t slot = 0; slot < wounded.model.cell_young.size(); slot++) {
      if (wounded.model.cell_young[slot] <= 0) continue;
      int corners[kCellCorners];
      for (int n = 0; n < kCellCorners; n++)
        corners[n] = node_slot(l, slot_node(l, int(slot)) + cell_corner(n));
      expect_different_colors(wounded, corners, "a cell"), whole++;
    }
    for (const SkinTriangle& t : wounded.model.skin.triangles)
      expect_different_colors(wounded, std::array{t.vertex.x, t.vertex.y, t.vertex.z}, "skin");
    for (const CutCellElement& part : wounded.state.parts.cells)
      expect_different_colors(wounded, part.corner, "part of a cell");
    for (const CutSkinElement& part : wounded.state.parts.skin)
      expect_different_colors(wounded, std::array{part.corner.x, part.corner.y, part.corner.z},
                              "part of skin");
    EXPECT_GT(whole, 3000);
    EXPECT_GT(wounded.state.parts.cells.size(), 50u);
    EXPECT_GT(wounded.state.parts.skin.size(), 10u);
  }
}

TEST(lattice_parts, a_wound_in_solid_tissue_has_the_same_bits_in_any_order_within_a_color) {
  Params params = solid_params(5, 4, 45);
  params.solver.ordering = Ordering::kColors;
  std::set<std::uint64_t> hashes;
  const auto hash_after = [&](const auto& sweep) {
    Wounded wounded(0.3, 0.5, 20, params);
    scatter(wounded.model, wounded.state, 0.0005);
    predict(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    for (const Order order : {Order::kForward, Order::kBackward}) sweep(wounded, order);
    hashes.insert(state_hash(wounded.model, wounded.state));
  };
  for (const int threads : {1, 2, 8})
    hash_after(
        [&](Wounded& w, Order order) { sweep_vbd(Exec(threads), w.model, w.state, {}, 1.0 / 60, order); });
  for (const unsigned seed : {1u, 2u})
    hash_after([&](Wounded& w, Order order) {
      sweep_vbd_by_colors(ShuffledRun{seed}, w.model, w.state, {}, 1.0 / 60, order);
    });
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(lattice_parts, a_wound_comes_to_rest_alike_by_colors_and_by_slabs) {
  for (const auto& [aside, degrees] : {std::pair{0.3, 20.0}, {0.2, 110.0}}) {
    double gape[2];
    for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
      Params params = solid_params(5, 8, 45);
      params.tissue.poisson = 0.45;
      params.solver.ordering = ordering;
      Wounded wounded(aside, 0.5, degrees, params);
      for (int n = 0; n < 60; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 30);
      gape[int(ordering)] = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
    }
    std::printf("%.1f aside, %3.0f degrees: %.4f mm by slabs, %.4f mm by colours\n", aside, degrees,
                1e3 * gape[0], 1e3 * gape[1]);
    EXPECT_NEAR(gape[1], gape[0], 1e-3 * gape[0]) << "m";
  }
}

TEST(lattice_parts, a_blade_that_moves_leaves_the_wound_that_one_at_once_does) {
  const Params params = solid_params(10, 4, 45);
  Wounded at_once(0.3, 0.5, 20, params), moving(0.3, 0.5, 20, params);
  State state = make_state(moving.model);
  for (int n = 0; n < 100; n++) {
    step(kOne, at_once.model, at_once.state, {}, 1.0 / 30);
    if (n < 20) cut_edges(moving.model, state, moving.path, n / 20.0, (n + 1) / 20.0, 0);
    EXPECT_TRUE(step(kOne, moving.model, state, {}, 1.0 / 30).finite);
  }
  EXPECT_EQ(state.parts.cells.size(), at_once.state.parts.cells.size());
  EXPECT_EQ(state.virtual_nodes.size(), at_once.state.virtual_nodes.size());
  const double once = measure_wound(at_once.model, at_once.state, at_once.path, 0).gape_max;
  EXPECT_NEAR(measure_wound(moving.model, state, moving.path, 0).gape_max, once, 0.01 * once) << "m";
}

/// Gapes of the first frames at 60 Hz.
std::vector<double> course(Wounded wounded, int frames) {
  std::vector<double> gapes;
  for (int n = 0; n < frames; n++) {
    EXPECT_TRUE(step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 60).finite);
    gapes.push_back(measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max);
  }
  return gapes;
}

TEST(lattice_parts, a_wound_goes_its_way_with_five_sweeps_as_with_hundreds) {
  for (const auto& [aside, degrees] : {std::pair{0.3, 20.0}, {0.2, 110.0}}) {
    Params many = solid_params(200, 1.2, 45), few = solid_params(5, 1.2, 45);
    many.tissue.poisson = few.tissue.poisson = 0.45, many.solver.coarse = false;
    constexpr int kFrames = 8;
    const std::vector<double> wanted = course(Wounded(aside, 0.5, degrees, many), kFrames);
    double farthest[2] = {};
    for (const bool coarse : {false, true}) {
      few.solver.coarse = coarse;
      const std::vector<double> gapes = course(Wounded(aside, 0.5, degrees, few), kFrames);
      for (int n = 0; n < kFrames; n++)
        farthest[coarse] = std::max(farthest[coarse],
                                    std::abs(gapes[std::size_t(n)] - wanted[std::size_t(n)]) / wanted.back());
    }
    std::printf("%.1f aside, %3.0f degrees: %.3f of the gape, %.3f by sweeps alone\n", aside, degrees,
                farthest[1], farthest[0]);
    EXPECT_LT(farthest[1], 0.08) << "of the gape, " << degrees << " degrees";
    EXPECT_GT(farthest[0], 0.5) << "of the gape, by sweeps alone";
  }
}

TEST(lattice_parts, a_wound_comes_to_rest_where_sweeps_alone_bring_it) {
  double gapes[2];
  for (const bool coarse : {false, true}) {
    Params params = solid_params(5, 4, 45);
    params.solver.coarse = coarse;
    Wounded wounded(0.3, 0.5, 20, params);
    for (int n = 0; n < 240; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 60);
    gapes[coarse] = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
  }
  EXPECT_NEAR(gapes[1], gapes[0], 1e-4 * gapes[0]) << "m";
}

TEST(lattice_parts, forces_left_over_cell_by_cell_are_those_node_by_node) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const Model& model = wounded.model;
  State& state = wounded.state;
  scatter(model, state, 0.0005);
  const Inputs inputs{.gravity = {1, 2, -9}};
  predict(kOne, model, state, inputs, 1.0 / 60);
  ASSERT_TRUE(prepare_coarse_space(model, state, inputs, 1.0 / 60));
  double sum2 = 0;
  const auto see = [&](int, int k, LayerForces forces) {
    for (int s = row_slot(model.lattice, 0, k); s < row_slot(model.lattice, Wounded::kN, k); s++)
      if (model.inverse_mass[std::size_t(s)] > 0) sum2 += dot(Vec3d(forces[s]), Vec3d(forces[s]));
  };
  find_left_over(kOne, model, state, *state.coarse, inputs, 1.0 / 60, state.residual_forces, see);
  for (const ElementNode& copy : state.parts.virtual_nodes) {
    if (model.inverse_mass[std::size_t(copy.slot)] == 0) continue;
    const VirtualNodeShift& f =
        state.residual_forces.virtual_nodes[std::size_t(copy.corner - slot_count(model.lattice))];
    sum2 += dot(Vec3d{f.x, f.y, f.z}, Vec3d{f.x, f.y, f.z});
  }
  const double rms = measure_residual(kOne, model, state, inputs, 1.0 / 60).rms;
  EXPECT_NEAR(std::sqrt(sum2 / model.free_nodes), rms, 1e-4 * rms) << "N";
}

TEST(lattice_parts, solving_for_the_smooth_part_never_raises_the_energy_of_a_step) {
  for (const double way : {1e-5, 5e-4, 4e-3}) {
    Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
    const Model& model = wounded.model;
    State& state = wounded.state;
    scatter(model, state, way);
    predict(kOne, model, state, {}, 1.0 / 60);
    ASSERT_TRUE(prepare_coarse_space(model, state, {}, 1.0 / 60));
    double before = step_energy(kOne, model, state, {}, 1.0 / 60);
    for (int n = 0; n < 4; n++) {
      apply_coarse_correction(kOne, model, state, {}, 1.0 / 60);
      const double after = step_energy(kOne, model, state, {}, 1.0 / 60);
      EXPECT_LE(after, before * (1 + 1e-6)) << "J, thrown " << way << " m";
      before = after;
    }
  }
}

TEST(lattice_parts, a_wound_has_equal_bits_on_1_2_and_8_threads) {
  std::uint64_t hashes[3];
  for (int n = 0; n < 3; n++) {
    Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
    for (int frame = 0; frame < 6; frame++)
      step(Exec(n == 0 ? 1 : n == 1 ? 2 : 8), wounded.model, wounded.state, {}, 1.0 / 60);
    hashes[n] = state_hash(wounded.model, wounded.state);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(lattice_parts, a_space_is_made_for_a_cut_and_not_for_rounded_times_or_parts_of_frames) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const auto space_after = [&](double dt) {
    step(kOne, wounded.model, wounded.state, {}, dt);
    return wounded.state.coarse.get();
  };
  const CoarseSpace* first = space_after(1.0 / 60);
  EXPECT_NE(first, nullptr);
  EXPECT_EQ(space_after(8.0 / 60 - 7.0 / 60), first);
  EXPECT_EQ(space_after(1.0 / 180), first) << "a third of a frame";
  EXPECT_EQ(space_after(1.0 / 60), first);
  const std::shared_ptr<const CoarseSpace> kept = wounded.state.coarse;
  EXPECT_NE(space_after(1.0 / 30), first);
}

/// How many spaces are made in some steps that begin when a part of a path is cut.
struct Makings {
  Wounded wounded;
  std::shared_ptr<const CoarseSpace> last;  // kept, so that no other has its address

  Makings() : wounded(0.3, 0.5, 20, solid_params(5, 4, 45)) {
    wounded.state = make_state(wounded.model);
    steps(3);
  }
  int steps(int count, Vec3d gravity = {}) {
    int made = 0;
    for (int n = 0; n < count; n++) {
      step(kOne, wounded.model, wounded.state, {.gravity = gravity}, 1.0 / 60);
      made += wounded.state.coarse != last;
      last = wounded.state.coarse;
    }
    return made;
  }
  int cut(double begin, double end, int count) {
    cut_edges(wounded.model, wounded.state, wounded.path, begin, end, 0);
    return steps(count);
  }
};

TEST(lattice_parts, a_body_at_rest_makes_no_space_before_something_moves_it) {
  Makings makings;
  EXPECT_EQ(makings.steps(3), 0);
  EXPECT_EQ(makings.last, nullptr);
  EXPECT_EQ(makings.steps(1, {0, 0, -9}), 1) << "gravity";
  EXPECT_EQ(makings.steps(3), 0) << "and it goes on to move";
}

TEST(lattice_parts, a_moving_blade_makes_one_space_when_it_is_through_and_none_on_its_way) {
  for (const int steps_a_cut : {1, 3}) {
    Makings moving;
    int on_its_way = 0;
    for (int n = 0; n < 9; n++) on_its_way += moving.cut(n / 10.0, (n + 1) / 10.0, steps_a_cut);
    EXPECT_EQ(on_its_way, 0);
    EXPECT_EQ(moving.cut(0.9, 1, 1), 1) << "in the step in which it is through";
    EXPECT_EQ(moving.steps(12), 0);
  }
}

TEST(lattice_parts, a_wound_cut_at_once_has_a_space_in_its_first_step) {
  Makings at_once;
  EXPECT_EQ(at_once.cut(0, 1, 1), 1);
  EXPECT_EQ(at_once.steps(12), 0);
}

TEST(lattice_parts, a_blade_that_stops_halfway_has_a_space_soon) {
  Makings stopped;
  EXPECT_EQ(stopped.cut(0, 0.5, 4), 0);
  EXPECT_EQ(stopped.steps(8), 1);
  EXPECT_EQ(stopped.cut(0.5, 1, 1), 1) << "and one when it goes on to the end";
}

}  // namespace
}  // namespace turgor::lattice
