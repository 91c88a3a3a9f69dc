// Where a state is between steps, and what goes over the bus for it.
#include "turgor/models/lattice/device/device_state.hpp"

#include <limits>
#include <thread>

#include "tests/models/host_side.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

struct Away {
  Model model;
  DeviceState state;

  explicit Away(TissueLaw law = TissueLaw::kSprings) {
    CutBlock block = cut_block(Method::kVbd, {13, 11, 9}, false, law);
    model = std::move(block.model), state = std::move(block.state);
    model.params.solver.coarse = false;
    state.step_on(put_on_host<SeededRun<1>>(model));
  }
  void step() { EXPECT_TRUE(state.step(kOne, model, {.gravity = {1, 0, -9.81}}, kDt).finite); }
  std::size_t vector_bytes() const { return 3 * sizeof(Real) * model.inverse_mass.size(); }
};

TEST(lattice_kept_state, frames_that_nobody_looks_at_bring_back_a_few_bytes) {
  Away there;
  there.step();
  Bus::over = Bus::back = 0;
  for (int n = 0; n < 10; n++) there.step();
  EXPECT_EQ(Bus::over, 10 * sizeof(StepMarks)) << "bytes";
  EXPECT_EQ(Bus::back, 10 * sizeof(StepMarks)) << "bytes";
  EXPECT_GT(there.state->u.x.size(), 0u);
  EXPECT_GE(Bus::back, 3 * there.vector_bytes());
  Bus::back = 0;
  (void)there.state.here();
  EXPECT_EQ(Bus::back, 0u) << "it is here";
}

TEST(lattice_kept_state, a_reference_from_before_a_step_holds_nothing_old) {
  Away there;
  there.step();
  const State& before = there.state.here();
  EXPECT_EQ(before.u.x.size(), there.model.inverse_mass.size());
  there.step();
  EXPECT_EQ(before.u.x.size(), 0u);
  EXPECT_EQ(before.v.z.size(), 0u);
}

TEST(lattice_kept_state, looking_changes_nothing) {
  Away looked, alone;
  std::uint64_t hash = 0;
  for (int n = 0; n < 6; n++) looked.step(), alone.step(), hash = state_hash(looked.model, looked.state);
  EXPECT_EQ(state_hash(alone.model, alone.state), hash);
}

TEST(lattice_kept_state, a_cut_takes_over_what_it_changed_alone) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    Away there(law);
    there.step();
    const BladePath path =
        lay_blade(there.model, there.state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}})
            .value();
    EXPECT_EQ(there.state.cuts(), cut_version(there.state));
    Bus::over = 0;
    there.step();
    EXPECT_EQ(Bus::over, sizeof(StepMarks)) << "laying a blade changes nothing";
    const State& known = there.state.without_places();
    for (const double half : {0.0, 0.5}) {
      const std::size_t before = known.virtual_nodes.size();
      Bus::over = Bus::back = 0;
      EXPECT_GT(there.state.cut_edges(there.model, path, half, half + 0.5, 1), 5);
      EXPECT_EQ(there.state.cut_edges(there.model, path, half, half + 0.5, 1), 0);
      EXPECT_TRUE(there.state.is_on_device());

      const std::size_t twice = (before + known.virtual_nodes.size()) * sizeof(VirtualNodeShift);
      const std::size_t nodes = (Bus::back - twice) / sizeof(NodeNow);
      EXPECT_EQ(Bus::back, twice + nodes * sizeof(NodeNow));
      EXPECT_EQ(nodes > 0, law == TissueLaw::kSolid) << "where there are new copies";
      EXPECT_LE(nodes, 8 * (known.virtual_nodes.size() - before)) << "corners of cells that were parted";
      const CutElements& parts = known.parts;
      const std::size_t follows = parts.cells.size() * sizeof(CutCellElement) +
                                  parts.skin.size() * sizeof(CutSkinElement) +
                                  parts.uses.size() * sizeof(NodeElement) +
                                  (parts.nodes.size() + parts.virtual_nodes.size()) * sizeof(ElementNode) +
                                  2 * known.virtual_nodes.size() * sizeof(VirtualNodeShift);
      EXPECT_GE(Bus::over, 2 * there.model.inverse_mass.size()) << "two bytes a slot";
      EXPECT_LE(Bus::over, 2 * there.model.inverse_mass.size() + known.row_cut.size() +
                               known.skin_cut.size() + follows + nodes * sizeof(int));
      Bus::over = 0;
      there.step();
      EXPECT_EQ(Bus::over, sizeof(StepMarks)) << "it is there";
    }
  }
}

TEST(lattice_kept_state, what_is_written_here_goes_over_before_the_next_step) {
  Away there;
  there.step();
  CutBlock here = cut_block(Method::kVbd, {13, 11, 9}, false);
  here.state = there.state.here();
  const auto slot = std::size_t(node_slot(here.model.lattice, 6, 5, 4));
  here.state.u.set(slot, {1e-3f, 0, 0});
  there.state.change().u.set(slot, {1e-3f, 0, 0});
  there.step();
  step(kOne, here.model, here.state, {.gravity = {1, 0, -9.81}}, kDt);
  const Apart found = apart(here.model, there.state, here.state);
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
}

TEST(lattice_kept_state, copies_step_on_the_same_side_each_with_its_own_numbers) {
  Away one;
  one.step();
  DeviceState copy = one.state;
  const std::uint64_t before = state_hash(one.model, copy);
  one.step();
  const std::uint64_t after = state_hash(one.model, one.state);
  EXPECT_EQ(state_hash(one.model, copy), before);
  const Inputs inputs{.gravity = {1, 0, -9.81}};
  one.step();  // stays away, while the copy takes its place
  copy.step(kOne, one.model, inputs, kDt);
  EXPECT_EQ(state_hash(one.model, copy), after);
  copy.step(kOne, one.model, inputs, kDt);
  EXPECT_EQ(state_hash(one.model, copy), state_hash(one.model, one.state));
  DeviceState other = std::move(copy);
  copy = DeviceState(State(*other));
  EXPECT_EQ(state_hash(one.model, copy), state_hash(one.model, one.state));
}

TEST(lattice_kept_state, views_that_are_watched_see_every_step_and_are_heard) {
  Away there, alone;
  const Real* u = there.state.watch().u.x.data();
  there.step(), alone.step();
  const State& now = alone.state.here();
  EXPECT_TRUE(std::equal(now.u.x.begin(), now.u.x.end(), u));
  const auto slot = std::size_t(node_slot(there.model.lattice, 6, 5, 4));
  const_cast<Real*>(u)[slot] += 1e-3f, alone.state.change().u.x[slot] += 1e-3f;
  there.step(), alone.step();
  EXPECT_EQ(state_hash(there.model, there.state), state_hash(alone.model, alone.state));
  EXPECT_EQ(there.state->u.x.data(), u);
}

TEST(lattice_kept_state, numbers_of_another_come_to_where_views_look) {
  Away there;
  const DeviceState begin = there.state;
  const std::uint64_t before = state_hash(there.model, begin);
  const Real* u = there.state.watch().u.x.data();
  there.step();
  EXPECT_NE(state_hash(there.model, there.state), before);
  there.state = begin;
  EXPECT_EQ(there.state->u.x.data(), u);
  EXPECT_EQ(state_hash(there.model, there.state), before);
  there.step();
  Away alone;
  alone.step();
  EXPECT_EQ(state_hash(there.model, there.state), state_hash(alone.model, alone.state));
}

TEST(lattice_kept_state, threads_may_look_at_once) {
  Away there;
  there.step();
  std::uint64_t hashes[2] = {};
  {
    std::jthread a([&] { hashes[0] = state_hash(there.model, there.state); });
    std::jthread b([&] { hashes[1] = state_hash(there.model, there.state); });
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(lattice_kept_state, without_another_side_it_is_a_state_that_steps_here) {
  CutBlock block = cut_block(Method::kVbd);
  DeviceState kept = block.state;
  kept.step(kOne, block.model, {}, kDt), step(kOne, block.model, block.state, {}, kDt);
  EXPECT_EQ(state_hash(block.model, kept), state_hash(block.model, block.state));
}

/// A wound, some frames after which nobody has looked.
struct AwayWound : Away {
  BladePath path;

  explicit AwayWound(TissueLaw law) : Away(law) {
    step();
    path = lay_blade(model, state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}}).value();
    EXPECT_GT(state.cut_edges(model, path, 0, 1, 1), 10);
    for (int n = 0; n < 5; n++) step();
  }
};

TEST(lattice_kept_state, a_wound_is_measured_and_its_surface_shown_by_the_nodes_behind_it) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    AwayWound there(law);
    const BodySurface surface = build_surface(there.model, there.state.without_places());
    const std::vector<int> beside = nodes_beside(there.model, there.state.without_places(), surface,
                                                 there.path, 1),
                           behind = nodes_behind(there.model, there.state.without_places(), surface);
    EXPECT_GT(beside.size(), 10u);
    EXPECT_LT(beside.size(), behind.size() / 2);
    Bus::over = Bus::back = 0;
    const Wound found = there.state.read_wound_nodes(beside, [&](const State& state) {
      return measure_wound(there.model, state, surface, there.path, 1);
    });
    const std::size_t virtual_nodes =
        there.state.without_places().virtual_nodes.size() * sizeof(VirtualNodeShift);
    EXPECT_EQ(Bus::back, beside.size() * sizeof(NodeNow) + virtual_nodes);
    EXPECT_EQ(Bus::over, beside.size() * sizeof(int));
    const TriMesh snapshot = there.state.read_wound_nodes(behind, [&](const State& state) {
      return deformed_surface(there.model, state, surface, Shown::kStretch);
    });
    EXPECT_TRUE(there.state.is_on_device());
    const State& all = there.state.here();
    const Wound right = measure_wound(there.model, all, surface, there.path, 1);
    EXPECT_GT(right.gape_max, 1e-4) << "m";
    EXPECT_EQ(found.gape_max, right.gape_max);
    EXPECT_EQ(found.edge_displacement, right.edge_displacement);
    EXPECT_EQ(found.opening_area, right.opening_area);
    const TriMesh now = deformed_surface(there.model, all, surface, Shown::kStretch);
    EXPECT_TRUE(snapshot.vertices == now.vertices && snapshot.normals == now.normals &&
                snapshot.scalars == now.scalars);
  }
}

TEST(lattice_kept_state, no_other_node_is_looked_at_by_measures_and_pictures) {
  AwayWound there(TissueLaw::kSolid);
  State state = there.state.here();
  const BodySurface surface = build_surface(there.model, state);
  const auto beside = nodes_beside(there.model, state, surface, there.path, 1);
  const auto behind = nodes_behind(there.model, state, surface);
  const Wound wound = measure_wound(there.model, state, surface, there.path, 1);
  const TriMesh snapshot = deformed_surface(there.model, state, surface, Shown::kDisplacement);
  const auto forget_all_but = [&](const std::vector<int>& nodes) {
    State some = state;
    const Real lost = std::numeric_limits<Real>::quiet_NaN();
    for (std::size_t s = 0; s < state.u.x.size(); s++)
      if (!std::binary_search(nodes.begin(), nodes.end(), int(s))) some.u.set(s, {lost, lost, lost});
    return some;
  };
  EXPECT_EQ(measure_wound(there.model, forget_all_but(beside), surface, there.path, 1).gape_max,
            wound.gape_max);
  EXPECT_EQ(deformed_surface(there.model, forget_all_but(behind), surface, Shown::kDisplacement).scalars,
            snapshot.scalars);
}

TEST(lattice_kept_state, places_in_balls_are_found_there_as_by_going_through_all_of_them) {
  Away there;
  const Vec3 h = there.model.lattice.step;
  std::vector<SurfaceSample> places;
  for (int s = 0; s < slot_count(there.model.lattice); s += 3)
    if (is_body(there.model.tissue[std::size_t(s)])) {
      const Vec3d rest(rest_position(there.model.lattice, slot_node(there.model.lattice, s)));
      places.push_back({s, rest + Vec3d{0.3 * double(h.x), 0, 0}, false, s % 2 == 0 ? s + 1 : -1});
    }
  std::vector<Ball> balls;
  balls.reserve(19);
  for (int b = 0; b < 19; b++)  // more than go at once, and some over each other
    balls.push_back({places[std::size_t(b * 7) % places.size()].rest, double(h.x) * (0.5 + 0.1 * b)});
  for (int n = 0; n < 3; n++) {
    there.step();
    std::vector<SurfaceSample> some(places.begin(), places.end() - n * 11);
    const std::vector<int> found = there.state.places_in(some, std::uint64_t(n + 1), balls);
    ASSERT_TRUE(there.state.is_on_device());
    EXPECT_GT(found.size(), 19u);
    EXPECT_LT(found.size(), some.size());
    EXPECT_EQ(found, places_in(some, there.state.here(), balls));
    EXPECT_EQ(found, there.state.places_in(some, std::uint64_t(n + 1), balls)) << "here";
    EXPECT_TRUE(there.state.places_in(some, std::uint64_t(n + 1), {}).empty());
  }
}

}  // namespace
}  // namespace turgor::lattice
