// Rows at rest are not swept, and measurements do not change.
#include "turgor/models/lattice/solver/sleep.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr double kDt = 1.0 / 60, kStep = 0.004, kSleep = 1e-5;

bool is_side(Int3 p, Int3 size) {
  return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
}

Model tense_block(Int3 size, double sleep, TissueLaw law = TissueLaw::kSprings,
                  Ordering ordering = Ordering::kSlabs) {
  Block block{.size = size, .spacing = kStep};
  block.is_fixed = [size](Int3 p) { return is_side(p, size); };
  Params params;
  params.tissue.law = law;
  params.solver.sleep_speed = sleep, params.solver.ordering = ordering;
  params.solver.sweeps = 6;
  return block_model(block, params);
}

struct Cut {
  State state;
  BladePath path;
};
/// A cut of six cells along x in the middle of the block's width, starting at `from`.
Cut cut_block(const Model& model, int from) {
  const Int3 size = model.anatomy.lattice.size;
  Cut cut{make_state(model), {}};
  const double y = (size.y / 2 - 0.5) * kStep, x = (from - 0.5) * kStep, z = (size.z - 2) * kStep;
  cut.path =
      lay_blade(model, cut.state, {.from = {x, y, z}, .to = {x + 6 * kStep, y, z}, .depth = 0.01}).value();
  EXPECT_GT(cut_edges(model, cut.state, cut.path, 0, 1, 0), 10);
  return cut;
}

/// Number of rows awake after a time [s].
int awake_after(const Model& model, State& state, double seconds, const Inputs& inputs = {}) {
  StepReport report;
  for (double t = 0; t < seconds; t += kDt) report = step(Exec(2), model, state, inputs, kDt);
  return report.rows - report.rows_asleep;
}

// A settled wound is that of a body that never sleeps.
TEST(LatticeSleep, SettledWoundMatchesAwakeBody) {
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

/// Gapes by frame of an oblique cut, and the number of rows awake at the end.
struct SlantedCut {
  std::vector<double> gape;
  int awake = 0;
};
SlantedCut open_slanted_cut(double step, double sleep) {
  const int n = int(std::lround(0.096 / step)) + 1, layers = int(std::lround(0.024 / step)) + 1;
  Block block{.size = {n, n, layers}, .spacing = step};
  block.is_fixed = [size = block.size](Int3 p) { return is_side(p, size); };
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  params.solver = {.sweeps = 5, .damping = 1.2, .sleep_speed = sleep};
  const Model model = block_model(block, params);
  State state = make_state(model);
  const Vec3d middle{(n / 2 + 0.3) * step, (n / 2 - 0.2) * step, 0.024},
      half = Vec3d{std::cos(0.5), std::sin(0.5), 0} * 0.018;
  const BladePath path =
      lay_blade(model, state, {.from = middle - half, .to = middle + half, .depth = 0.012}).value();
  cut_edges(model, state, path, 0, 1, 0);
  SlantedCut sleeping;
  for (int frame = 0; frame < 160; frame++) {
    const StepReport report = lattice::step(Exec(2), model, state, {}, kDt);
    sleeping.awake = report.rows - report.rows_asleep;
    sleeping.gape.push_back(measure_wound(model, state, path, 0).gape_max);
  }
  return sleeping;
}

// With a coarse space, sleeping rows follow, and a wound opens as in a body that never sleeps.
TEST(LatticeSleep, CoarseSpaceMovesSleepingRows) {
  for (const auto& [step, sleep] : {std::pair{0.004, 3e-4}, {0.003, 1e-3}}) {
    const SlantedCut wakeful = open_slanted_cut(step, 0), sleeping = open_slanted_cut(step, sleep);
    EXPECT_EQ(sleeping.awake, 0) << "step " << step;
    const double gape = wakeful.gape.back();
    EXPECT_GT(gape, 3e-3);
    EXPECT_NEAR(sleeping.gape.back(), gape, 1e-3 * gape) << "step " << step;
    double farthest = 0;
    for (std::size_t n = 0; n < sleeping.gape.size(); n++)
      farthest = std::max(farthest, std::abs(sleeping.gape[n] - wakeful.gape[n]) / gape);
    EXPECT_LT(farthest, 0.01) << "at any frame, cell size " << step;
  }
}

// A cut wakes the same number of rows in a body with twice the nodes.
TEST(LatticeSleep, WokenRowsIndependentOfBodySize) {
  int awake[2];
  for (const int times : {1, 2}) {
    const Model model = tense_block({25, 100 * times, 9}, 1e-3);
    State state = make_state(model);
    EXPECT_EQ(awake_after(model, state, 1), 0) << "at rest as the CT shows it";
    Cut cut = cut_block(model, 9);
    state.cuts.cut = cut.state.cuts.cut, state.cuts.edges = cut.state.cuts.edges,
    state.cuts.row_cut = cut.state.cuts.row_cut;
    state.cuts.skin_cut = cut.state.cuts.skin_cut;
    int most = 0;
    for (int n = 0; n < 60; n++) most = std::max(most, awake_after(model, state, kDt));
    EXPECT_GT(measure_wound(model, state, cut.path, 0).gape_max, 0.5e-3);
    awake[times > 1] = most;
  }
  EXPECT_EQ(awake[1], awake[0]) << "largest number of rows awake";
}

// A load or a contact moves a sleeping body as one that is awake.
TEST(LatticeSleep, LoadsAndContactsWakeBody) {
  for (const auto& [law, pressed] : {std::pair{TissueLaw::kSprings, false},
                                     {TissueLaw::kSprings, true},
                                     {TissueLaw::kSolid, false},
                                     {TissueLaw::kSolid, true}}) {
    Vec3 moved[2];
    for (const bool sleeps : {false, true}) {
      const Model model = tense_block({13, 13, 9}, sleeps ? kSleep : 0, law);
      State state = make_state(model);
      awake_after(model, state, 1);
      const int slot = node_slot(model.anatomy.lattice, 6, 6, 8);
      const NodeLoad loads[] = {{slot, {0.02f, 0, -0.05f}}};
      NodeContact contacts[] = {{.slot = slot, .normal = {0, 0, -1}, .target = {0, 0, -1e-3f}}};
      Inputs inputs;
      if (pressed)
        inputs.contacts = contacts;
      else
        inputs.loads = loads;
      awake_after(model, state, 6, inputs);
      moved[sleeps] = state.motion.u[std::size_t(slot)];
    }
    EXPECT_GT(norm(moved[0]), 0.2e-3);
    EXPECT_LT(norm(moved[1] - moved[0]), 1e-3 * norm(moved[0]))
        << "pressed " << pressed << ", law " << int(law);
  }
}

/// A phantom torso, curved and with a staircase surface, under anisotropic tension.
Model tense_torso(double sleep, TissueLaw law, SkinLaw skin) {
  PhantomParams phantom = default_phantom(PhantomKind::kTorso);
  phantom.size = {64, 64, 38}, phantom.spacing *= 8;
  Params params;
  params.tissue.law = law;
  params.solver.sleep_speed = sleep;
  params.skin.law = skin;
  params.skin.tension_along = 130, params.skin.tension_across = 25, params.skin.direction = {1, 0.4, 0.7};
  return build(Exec(2), make_phantom(Exec(2), phantom), {}, params).value();
}

// An undisturbed body is at rest and starts asleep.
TEST(LatticeSleep, UndisturbedBodyStartsAsleep) {
  for (const auto& [law, skin] : {std::pair{TissueLaw::kSprings, SkinLaw::kFiber},
                                  {TissueLaw::kSolid, SkinLaw::kFiber},
                                  {TissueLaw::kSolid, SkinLaw::kArea}}) {
    const Model wakeful = tense_torso(0, law, skin), model = tense_torso(kSleep, law, skin);
    State awake = make_state(wakeful), state = make_state(model);
    double fastest = 0, farthest = 0;
    for (int n = 0; n < 120; n++)
      fastest = std::max(fastest, double(step(Exec(2), wakeful, awake, {}, kDt).largest_speed));
    for (std::size_t s = 0; s < awake.motion.u.x.size(); s++)
      farthest = std::max(farthest, double(norm(awake.motion.u[s])));
    EXPECT_LT(fastest, 0.1 * kSleep) << "law " << int(law);
    EXPECT_LT(farthest, kSleep * kDt) << "in two seconds, law " << int(law);
    const StepReport report = step(Exec(2), model, state, {}, kDt);
    EXPECT_GT(report.rows, 50);
    EXPECT_EQ(report.rows_asleep, report.rows) << "law " << int(law);
  }
}

// A body that has been moved starts awake.
TEST(LatticeSleep, MovedBodyStartsAwake) {
  for (const bool is_fast : {false, true}) {
    const Model model = tense_block({9, 9, 9}, kSleep);
    State state = make_state(model);
    VecField& field = is_fast ? state.motion.v : state.motion.u;
    field.set(std::size_t(node_slot(model.anatomy.lattice, 4, 4, 4)), {0, 0, 1e-5f});
    EXPECT_EQ(awake_after(model, state, kDt), 7 * 8) << "is fast " << is_fast;
  }
}

// A wound in a body that was asleep from the start is that of a body that never sleeps.
TEST(LatticeSleep, CutOfSleepingBodyMatchesAwakeBody) {
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
      for (int n = 0; n < 20; n++) {  // a moving blade
        cut_edges(model, state, path, n / 20.0, (n + 1) / 20.0, 0);
        most = std::max(most, awake_after(model, state, kDt));
      }
      EXPECT_EQ(most > 20, sleeps) << "largest number of rows awake: " << most;
      EXPECT_EQ(awake_after(model, state, 5), 0);
      gape[sleeps] = measure_wound(model, state, path, 0).gape_max;
    }
    EXPECT_GT(gape[0], 0.5e-3);
    EXPECT_NEAR(gape[1], gape[0], 1e-3 * gape[0]) << "law " << int(law);
  }
}

// A change of gravity wakes all rows.
TEST(LatticeSleep, ChangedGravityWakesAllRows) {
  const Model model = tense_block({9, 9, 9}, kSleep);
  State state = make_state(model);
  EXPECT_EQ(awake_after(model, state, 1), 0);
  EXPECT_EQ(awake_after(model, state, kDt, {.gravity = {0, 0, -9.81}}), 7 * 8);
  EXPECT_GT(awake_after(model, state, 0.2, {.gravity = {0, 0, -9.81}}), 0);
}

// Removed tissue wakes its neighbors.
TEST(LatticeSleep, RemovedTissueWakesNeighbors) {
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

// A swinging body does not fall asleep at its turning points.
TEST(LatticeSleep, SwingingBodyStaysAwake) {
  Block block{.size = {5, 5, 25}, .spacing = kStep, .young = 2e4, .skin_on_top = false};
  block.is_fixed = [](Int3 p) { return p.z == 0; };
  Params params;
  params.solver = {.sweeps = 20, .damping = 0, .sleep_speed = kSleep};
  const Model model = block_model(block, params);
  State state = make_state(model);
  for (int n = 0; n < 120; n++) {
    const StepReport report = step(Exec(1), model, state, {.gravity = {1, 0, 0}}, kDt);
    ASSERT_EQ(report.rows_asleep, 0) << "frame " << n;
  }
}

// One, two and eight threads give the same bits, repeatedly.
TEST(LatticeSleep, EqualBitsOnAnyThreads) {
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

// The hash of a state includes its sleeping rows.
TEST(LatticeSleep, HashIncludesSleep) {
  const Model model = tense_block({9, 9, 9}, kSleep);
  State a = make_state(model);
  awake_after(model, a, 0.05);
  State b = a;
  EXPECT_EQ(state_hash(model, a), state_hash(model, b));
  b.sleep.still_steps[b.sleep.still_steps.size() / 2]++;
  EXPECT_NE(state_hash(model, a), state_hash(model, b));
}

// A change of gravity moves a body with a sleeping coarse space as one that is awake.
TEST(LatticeSleep, ChangedGravityWakesCoarseSpace) {
  double sag[2];
  for (const bool sleeps : {false, true}) {
    const Model model = tense_block({13, 25, 13}, sleeps ? 1e-4 : 0, TissueLaw::kSolid);
    State state = make_state(model);
    const Vec3d weak{0, 0, -1}, strong{0.5, 0, -9.81};
    EXPECT_EQ(awake_after(model, state, 6, {.gravity = weak}), 0);
    EXPECT_EQ(state.sleep.coarse_still_steps >= kStillSteps, sleeps);
    awake_after(model, state, 4, {.gravity = strong});
    sag[sleeps] = double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, 6, 12, 12))].z);
  }
  EXPECT_LT(sag[0], -0.1e-3);
  EXPECT_NEAR(sag[1], sag[0], 2e-3 * std::abs(sag[0]));
}

}  // namespace
}  // namespace turgor::lattice
