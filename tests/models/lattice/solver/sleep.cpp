// Rows that stand still are not swept, and nothing that is measured tells.
#include "turgor/models/lattice/solver/sleep.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {
namespace {

constexpr double kDt = 1.0 / 60, kStep = 0.004, kSleep = 1e-5;

bool is_side(Int3 p, Int3 size) {
  return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
}

Model tense_block(Int3 size, double sleep, TissueLaw law = TissueLaw::kSprings,
                  Ordering ordering = Ordering::kSlabs) {
  Block block{.size = size, .step = kStep};
  block.is_fixed = [size](Int3 p) { return is_side(p, size); };
  Params params;
  params.tissue.law = law;
  params.solver.sleep = sleep, params.solver.ordering = ordering;
  params.solver.sweeps = 6;
  return block_model(block, params);
}

struct Cut {
  State state;
  BladePath path;
};
/// A cut of six steps along x in the middle of a block, as wide as `size.y` is, from `from` on.
Cut cut_block(const Model& model, int from) {
  const Int3 size = model.lattice.size;
  Cut cut{make_state(model), {}};
  const double y = (size.y / 2 - 0.5) * kStep, x = (from - 0.5) * kStep, z = (size.z - 2) * kStep;
  cut.path =
      lay_blade(model, cut.state, {.from = {x, y, z}, .to = {x + 6 * kStep, y, z}, .depth = 0.01}).value();
  EXPECT_GT(cut_edges(model, cut.state, cut.path, 0, 1, 0), 10);
  return cut;
}

/// Rows awake after a time [s].
int awake_after(const Model& model, State& state, double seconds, const Inputs& inputs = {}) {
  StepReport report;
  for (double t = 0; t < seconds; t += kDt) report = step(Exec(2), model, state, inputs, kDt);
  return report.rows - report.rows_asleep;
}

TEST(lattice_sleep, the_settled_wound_is_that_of_a_body_that_never_sleeps) {
  for (const auto& [law, ordering] : {std::pair{TissueLaw::kSprings, Ordering::kSlabs},
                                      {TissueLaw::kSolid, Ordering::kSlabs},
                                      {TissueLaw::kSprings, Ordering::kColors}}) {
    double gape[2];
    for (const bool sleeps : {false, true}) {
      const Model model = tense_block({21, 21, 8}, sleeps ? kSleep : 0, law, ordering);
      auto [state, path] = cut_block(model, 7);
      const int awake = awake_after(model, state, 5);
      EXPECT_EQ(awake, 0) << "sleeps " << sleeps << ", law " << int(law);
      gape[sleeps] = measure_wound(model, state, path, 0).gape_max;
    }
    EXPECT_GT(gape[0], 0.5e-3);
    EXPECT_NEAR(gape[1], gape[0], 1e-3 * gape[0]) << "law " << int(law);
  }
}

/// Gapes by frame of a cut aslant to the lattice, and the rows that are awake at last.
struct Way {
  std::vector<double> gape;
  int awake = 0;
};
Way way_of_a_slanted_cut(double step, double sleep) {
  const int n = int(std::lround(0.096 / step)) + 1, layers = int(std::lround(0.024 / step)) + 1;
  Block block{.size = {n, n, layers}, .step = step};
  block.is_fixed = [size = block.size](Int3 p) { return is_side(p, size); };
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  params.solver = {.sweeps = 5, .damping = 1.2, .sleep = sleep};
  const Model model = block_model(block, params);
  State state = make_state(model);
  const Vec3d middle{(n / 2 + 0.3) * step, (n / 2 - 0.2) * step, 0.024},
      half = Vec3d{std::cos(0.5), std::sin(0.5), 0} * 0.018;
  const BladePath path =
      lay_blade(model, state, {.from = middle - half, .to = middle + half, .depth = 0.012}).value();
  cut_edges(model, state, path, 0, 1, 0);
  Way way;
  for (int frame = 0; frame < 160; frame++) {
    const StepReport report = lattice::step(Exec(2), model, state, {}, kDt);
    way.awake = report.rows - report.rows_asleep;
    way.gape.push_back(measure_wound(model, state, path, 0).gape_max);
  }
  return way;
}

TEST(lattice_sleep, with_a_coarse_space_sleepers_follow_and_a_wound_opens_as_in_a_body_that_never_sleeps) {
  for (const auto& [step, sleep] : {std::pair{0.004, 3e-4}, {0.003, 1e-3}}) {
    const Way wakeful = way_of_a_slanted_cut(step, 0), way = way_of_a_slanted_cut(step, sleep);
    EXPECT_EQ(way.awake, 0) << "step " << step;
    const double gape = wakeful.gape.back();
    EXPECT_GT(gape, 3e-3);
    EXPECT_NEAR(way.gape.back(), gape, 1e-3 * gape) << "step " << step;
    double farthest = 0;
    for (std::size_t n = 0; n < way.gape.size(); n++)
      farthest = std::max(farthest, std::abs(way.gape[n] - wakeful.gape[n]) / gape);
    EXPECT_LT(farthest, 0.01) << "on its way, step " << step;
  }
}

TEST(lattice_sleep, a_cut_in_a_body_of_twice_the_nodes_wakes_as_many_rows) {
  int awake[2];
  for (const int times : {1, 2}) {
    const Model model = tense_block({25, 100 * times, 9}, 1e-3);
    State state = make_state(model);
    EXPECT_EQ(awake_after(model, state, 1), 0) << "at rest as the CT shows it";
    Cut cut = cut_block(model, 9);
    state.cut = cut.state.cut, state.cut_edges = cut.state.cut_edges, state.row_cut = cut.state.row_cut;
    state.skin_cut = cut.state.skin_cut;
    int most = 0;
    for (int n = 0; n < 60; n++) most = std::max(most, awake_after(model, state, kDt));
    EXPECT_GT(measure_wound(model, state, cut.path, 0).gape_max, 0.5e-3);
    awake[times > 1] = most;
  }
  EXPECT_EQ(awake[1], awake[0]) << "rows awake at most";
}

TEST(lattice_sleep, a_load_or_a_contact_on_a_sleeping_body_moves_it_as_one_that_is_awake) {
  for (const auto& [law, pressed] : {std::pair{TissueLaw::kSprings, false},
                                     {TissueLaw::kSprings, true},
                                     {TissueLaw::kSolid, false},
                                     {TissueLaw::kSolid, true}}) {
    Vec3 moved[2];
    for (const bool sleeps : {false, true}) {
      const Model model = tense_block({13, 13, 9}, sleeps ? kSleep : 0, law);
      State state = make_state(model);
      awake_after(model, state, 1);
      const int slot = node_slot(model.lattice, 6, 6, 8);
      const NodeLoad loads[] = {{slot, {0.02f, 0, -0.05f}}};
      NodeContact contacts[] = {{.slot = slot, .normal = {0, 0, -1}, .target = {0, 0, -1e-3f}}};
      Inputs inputs;
      if (pressed)
        inputs.contacts = contacts;
      else
        inputs.loads = loads;
      awake_after(model, state, 6, inputs);
      moved[sleeps] = state.u[std::size_t(slot)];
    }
    EXPECT_GT(norm(moved[0]), 0.2e-3);
    EXPECT_LT(norm(moved[1] - moved[0]), 1e-3 * norm(moved[0]))
        << "pressed " << pressed << ", law " << int(law);
  }
}

/// A torso of the phantom, curved and with steps of its surface, under tension that is not alike in all
/// directions.
Model tense_torso(double sleep, TissueLaw law, SkinLaw skin) {
  PhantomParams phantom = default_phantom(PhantomKind::kTorso);
  phantom.size = {64, 64, 38}, phantom.spacing *= 8;
  Params params;
  params.tissue.law = law;
  params.solver.sleep = sleep;
  params.skin.law = skin;
  params.skin.tension_along = 130, params.skin.tension_across = 25, params.skin.direction = {1, 0.4, 0.7};
  return build(Exec(2), make_phantom(Exec(2), phantom), {}, params).value();
}

TEST(lattice_sleep, a_body_to_which_nothing_has_happened_is_at_rest_and_begins_asleep) {
  for (const auto& [law, skin] : {std::pair{TissueLaw::kSprings, SkinLaw::kFiber},
                                  {TissueLaw::kSolid, SkinLaw::kFiber},
                                  {TissueLaw::kSolid, SkinLaw::kArea}}) {
    const Model wakeful = tense_torso(0, law, skin), model = tense_torso(kSleep, law, skin);
    State awake = make_state(wakeful), state = make_state(model);
    double fastest = 0, farthest = 0;
    for (int n = 0; n < 120; n++)
      fastest = std::max(fastest, double(step(Exec(2), wakeful, awake, {}, kDt).largest_speed));
    for (std::size_t s = 0; s < awake.u.x.size(); s++)
      farthest = std::max(farthest, double(norm(awake.u[s])));
    EXPECT_LT(fastest, 0.1 * kSleep) << "law " << int(law);
    EXPECT_LT(farthest, kSleep * kDt) << "in two seconds, law " << int(law);
    const StepReport report = step(Exec(2), model, state, {}, kDt);
    EXPECT_GT(report.rows, 50);
    EXPECT_EQ(report.rows_asleep, report.rows) << "law " << int(law);
  }
}

TEST(lattice_sleep, a_body_that_has_been_moved_begins_awake) {
  for (const bool is_fast : {false, true}) {
    const Model model = tense_block({9, 9, 9}, kSleep);
    State state = make_state(model);
    VecField& field = is_fast ? state.v : state.u;
    field.set(std::size_t(node_slot(model.lattice, 4, 4, 4)), {0, 0, 1e-5f});
    EXPECT_EQ(awake_after(model, state, kDt), 7 * 8) << "is fast " << is_fast;
  }
}

TEST(lattice_sleep,
     a_wound_cut_into_a_body_that_has_slept_from_the_beginning_is_that_of_one_that_never_sleeps) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    double gape[2];
    for (const bool sleeps : {false, true}) {
      const Model model = tense_block({23, 17, 9}, sleeps ? kSleep : 0, law);
      State state = make_state(model);
      EXPECT_EQ(awake_after(model, state, kDt), 0);
      const Vec3d from{6.3 * kStep, 5.2 * kStep, 8 * kStep};
      const BladePath path =
          lay_blade(model, state, {.from = from, .to = from + Vec3d{0.03, 0.02, 0}, .depth = 0.013}).value();
      int most = 0;
      for (int n = 0; n < 20; n++) {  // a blade on its way
        cut_edges(model, state, path, n / 20.0, (n + 1) / 20.0, 0);
        most = std::max(most, awake_after(model, state, kDt));
      }
      EXPECT_EQ(most > 20, sleeps) << "rows awake at most: " << most;
      EXPECT_EQ(awake_after(model, state, 5), 0);
      gape[sleeps] = measure_wound(model, state, path, 0).gape_max;
    }
    EXPECT_GT(gape[0], 0.5e-3);
    EXPECT_NEAR(gape[1], gape[0], 1e-3 * gape[0]) << "law " << int(law);
  }
}

TEST(lattice_sleep, new_gravity_wakes_all) {
  const Model model = tense_block({9, 9, 9}, kSleep);
  State state = make_state(model);
  EXPECT_EQ(awake_after(model, state, 1), 0);
  EXPECT_EQ(awake_after(model, state, kDt, {.gravity = {0, 0, -9.81}}), 7 * 8);
  EXPECT_GT(awake_after(model, state, 0.2, {.gravity = {0, 0, -9.81}}), 0);
}

TEST(lattice_sleep, tissue_that_leaves_the_body_wakes_what_it_held) {
  double gape[2];
  for (const bool sleeps : {false, true}) {
    const Model model = tense_block({21, 21, 8}, sleeps ? kSleep : 0);
    State state = make_state(model);
    awake_after(model, state, 1);
    const Vec3d from{6 * kStep, 10 * kStep, 6 * kStep};
    const Incision blade{
        .from = from, .to = from + Vec3d{8 * kStep, 0, 0}, .depth = 0.01, .width = 1.5 * kStep};
    const BladePath path = lay_blade(model, state, blade).value();
    EXPECT_GT(cut_region(model, state, path), 10);
    awake_after(model, state, 5);
    gape[sleeps] = measure_wound(model, state, path, 0).gape_max;
  }
  EXPECT_GT(gape[0], 0.2e-3);
  EXPECT_NEAR(gape[1], gape[0], 1e-2 * gape[0]);
}

TEST(lattice_sleep, what_swings_does_not_fall_asleep_where_it_turns) {
  Block block{.size = {5, 5, 25}, .step = kStep, .young = 2e4, .skin_on_top = false};
  block.is_fixed = [](Int3 p) { return p.z == 0; };
  Params params;
  params.solver = {.sweeps = 20, .damping = 0, .sleep = kSleep};
  const Model model = block_model(block, params);
  State state = make_state(model);
  for (int n = 0; n < 120; n++) {
    const StepReport report = step(Exec(1), model, state, {.gravity = {1, 0, 0}}, kDt);
    ASSERT_EQ(report.rows_asleep, 0) << "frame " << n;
  }
}

TEST(lattice_sleep, equal_bits_on_1_2_and_8_threads_and_again) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    std::set<std::uint64_t> hashes;
    int asleep = 0;
    for (const int threads : {1, 2, 8, 8}) {
      const Model model = tense_block({25, 33, 13}, 1e-3, law);
      auto [state, path] = cut_block(model, 9);
      for (int n = 0; n < 40; n++) asleep = step(Exec(threads), model, state, {}, kDt).rows_asleep;
      EXPECT_GT(asleep, 0);
      hashes.insert(state_hash(model, state));
    }
    EXPECT_EQ(hashes.size(), 1u) << "law " << int(law);
  }
}

TEST(lattice_sleep, who_sleeps_is_part_of_the_state) {
  const Model model = tense_block({9, 9, 9}, kSleep);
  State a = make_state(model);
  awake_after(model, a, 0.05);
  State b = a;
  EXPECT_EQ(state_hash(model, a), state_hash(model, b));
  b.sleep.still[b.sleep.still.size() / 2]++;
  EXPECT_NE(state_hash(model, a), state_hash(model, b));
}

TEST(lattice_sleep, new_gravity_moves_a_body_whose_coarse_space_sleeps_as_one_that_is_awake) {
  double sag[2];
  for (const bool sleeps : {false, true}) {
    const Model model = tense_block({13, 25, 13}, sleeps ? 1e-4 : 0, TissueLaw::kSolid);
    State state = make_state(model);
    const Vec3d weak{0, 0, -1}, strong{0.5, 0, -9.81};
    EXPECT_EQ(awake_after(model, state, 6, {.gravity = weak}), 0);
    EXPECT_EQ(state.sleep.coarse_still >= kStillSteps, sleeps);
    awake_after(model, state, 4, {.gravity = strong});
    sag[sleeps] = double(state.u[std::size_t(node_slot(model.lattice, 6, 12, 12))].z);
  }
  EXPECT_LT(sag[0], -0.1e-3);
  EXPECT_NEAR(sag[1], sag[0], 2e-3 * std::abs(sag[0]));
}

}  // namespace
}  // namespace turgor::lattice
