// Synchronization of a state between host and device, and the bytes that it transfers.
#include "turgor/models/lattice/device/device_state.hpp"

#include <limits>
#include <thread>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

struct OnDevice {
  Model model;
  DeviceState state;

  explicit OnDevice(TissueLaw law = TissueLaw::kSprings) {
    CutBlock block = cut_block(Method::kVbd, {13, 11, 9}, false, law);
    model = std::move(block.model), state = std::move(block.state);
    model.params.solver.coarse = false;
    state.use_backend(put_on_host<SeededRun<1>>(model));
  }
  void step() { EXPECT_TRUE(state.step(kOne, model, {.gravity = {1, 0, -9.81}}, kDt).finite); }
  std::size_t vector_bytes() const { return 3 * sizeof(Real) * model.anatomy.inverse_mass.size(); }
};

// Frames whose state is not read download a summary only; a read downloads the state once.
TEST(DeviceState, UnreadFramesDownloadFewBytes) {
  OnDevice device;
  device.step();
  Transfers::uploaded = Transfers::downloaded = 0;
  for (int n = 0; n < 10; n++) device.step();
  EXPECT_EQ(Transfers::uploaded, 10 * sizeof(StepSummary)) << "bytes";
  EXPECT_EQ(Transfers::downloaded, 10 * sizeof(StepSummary)) << "bytes";
  EXPECT_GT(device.state->motion.u.x.size(), 0u);
  EXPECT_GE(Transfers::downloaded, 3 * device.vector_bytes());
  Transfers::downloaded = 0;
  (void)device.state.host();
  EXPECT_EQ(Transfers::downloaded, 0u) << "already on the host";
}

// A reference to the host state has no outdated values after a step.
TEST(DeviceState, StepInvalidatesHostReference) {
  OnDevice device;
  device.step();
  const State& before = device.state.host();
  EXPECT_EQ(before.motion.u.x.size(), device.model.anatomy.inverse_mass.size());
  device.step();
  EXPECT_EQ(before.motion.u.x.size(), 0u);
  EXPECT_EQ(before.motion.v.z.size(), 0u);
}

// Downloads do not change the results.
TEST(DeviceState, DownloadDoesNotChangeResults) {
  OnDevice downloaded, alone;
  std::uint64_t hash = 0;
  for (int n = 0; n < 6; n++)
    downloaded.step(), alone.step(), hash = state_hash(downloaded.model, downloaded.state);
  EXPECT_EQ(state_hash(alone.model, alone.state), hash);
}

// A cut transfers only what it changes.
TEST(DeviceState, CutUploadsOnlyChanges) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    OnDevice device(law);
    device.step();
    const BladePath path =
        lay_blade(device.model, device.state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}})
            .value();
    EXPECT_EQ(cut_version(device.state.cuts()), cut_version(device.state->cuts));
    Transfers::uploaded = 0;
    device.step();
    EXPECT_EQ(Transfers::uploaded, sizeof(StepSummary)) << "laying a blade changes nothing";
    for (const double half : {0.0, 0.5}) {
      const std::size_t before = device.state.virtual_u().size();
      Transfers::uploaded = Transfers::downloaded = 0;
      EXPECT_GT(device.state.cut_edges(device.model, path, half, half + 0.5, 1), 5);
      EXPECT_EQ(device.state.cut_edges(device.model, path, half, half + 0.5, 1), 0);
      EXPECT_TRUE(device.state.is_on_device());

      const std::size_t twice = (before + device.state.virtual_u().size()) * sizeof(VirtualNodeDisplacement);
      const std::size_t nodes = (Transfers::downloaded - twice) / sizeof(VectorPair);
      EXPECT_EQ(Transfers::downloaded, twice + nodes * sizeof(VectorPair));
      EXPECT_EQ(nodes > 0, law == TissueLaw::kSolid) << "if there are new virtual nodes";
      EXPECT_LE(nodes, 8 * (device.state.virtual_u().size() - before)) << "corners of divided cells";
      const CutElements& elements = device.state.cut_elements();
      const std::size_t follows =
          elements.cells.size() * sizeof(CutCellElement) + elements.skin.size() * sizeof(CutSkinElement) +
          elements.references.size() * sizeof(NodeElementReference) +
          (elements.nodes.size() + elements.virtual_nodes.size()) * sizeof(ElementNode) +
          2 * device.state.virtual_u().size() * sizeof(VirtualNodeDisplacement);
      const std::size_t slots = device.model.anatomy.inverse_mass.size();
      const std::size_t listed = list_nodes(device.model, device.state.cuts().row_cut, {}).slots.size();
      EXPECT_LT(listed, slots / 2);
      EXPECT_GE(Transfers::uploaded, 3 * slots) << "three bytes per slot";
      EXPECT_LE(Transfers::uploaded, 3 * slots + device.state.cuts().row_cut.size() +
                                         device.state.cuts().skin_cut.size() + follows +
                                         (nodes + listed) * sizeof(int));
      Transfers::uploaded = 0;
      device.step();
      EXPECT_EQ(Transfers::uploaded, sizeof(StepSummary)) << "already on the device";
    }
  }
}

// Host writes are uploaded before the next step.
TEST(DeviceState, HostWritesAreUploaded) {
  OnDevice device;
  device.step();
  CutBlock host = cut_block(Method::kVbd, {13, 11, 9}, false);
  host.state = device.state.host();
  const auto slot = std::size_t(node_slot(host.model.anatomy.lattice, 6, 5, 4));
  host.state.motion.u.set(slot, {1e-3f, 0, 0});
  device.state.change().motion.u.set(slot, {1e-3f, 0, 0});
  device.step();
  step(kOne, host.model, host.state, {.gravity = {1, 0, -9.81}}, kDt);
  const StateDifference found = state_difference(host.model, device.state, host.state);
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
}

// Copies of a state step independently on the same backend.
TEST(DeviceState, CopiesStepIndependently) {
  OnDevice one;
  one.step();
  DeviceState copy = one.state;
  const std::uint64_t before = state_hash(one.model, copy);
  one.step();
  const std::uint64_t after = state_hash(one.model, one.state);
  EXPECT_EQ(state_hash(one.model, copy), before);
  const Inputs inputs{.gravity = {1, 0, -9.81}};
  one.step();  // stays on the device, while the copy replaces it in the backend
  copy.step(kOne, one.model, inputs, kDt);
  EXPECT_EQ(state_hash(one.model, copy), after);
  copy.step(kOne, one.model, inputs, kDt);
  EXPECT_EQ(state_hash(one.model, copy), state_hash(one.model, one.state));
  DeviceState other = std::move(copy);
  copy = DeviceState(State(*other));
  EXPECT_EQ(state_hash(one.model, copy), state_hash(one.model, one.state));
}

// Watched views are downloaded after every step, and their changes are uploaded.
TEST(DeviceState, WatchedViewsAreSynchronized) {
  OnDevice device, alone;
  const Real* u = device.state.watch().motion.u.x.data();
  device.step(), alone.step();
  const State& now = alone.state.host();
  EXPECT_TRUE(std::equal(now.motion.u.x.begin(), now.motion.u.x.end(), u));
  const auto slot = std::size_t(node_slot(device.model.anatomy.lattice, 6, 5, 4));
  const_cast<Real*>(u)[slot] += 1e-3f, alone.state.change().motion.u.x[slot] += 1e-3f;
  device.step(), alone.step();
  EXPECT_EQ(state_hash(device.model, device.state), state_hash(alone.model, alone.state));
  EXPECT_EQ(device.state->motion.u.x.data(), u);
}

// Assignment of another state writes into the memory of watched views.
TEST(DeviceState, AssignmentKeepsWatchedViews) {
  OnDevice device;
  const DeviceState begin = device.state;
  const std::uint64_t before = state_hash(device.model, begin);
  const Real* u = device.state.watch().motion.u.x.data();
  device.step();
  EXPECT_NE(state_hash(device.model, device.state), before);
  device.state = begin;
  EXPECT_EQ(device.state->motion.u.x.data(), u);
  EXPECT_EQ(state_hash(device.model, device.state), before);
  device.step();
  OnDevice alone;
  alone.step();
  EXPECT_EQ(state_hash(device.model, device.state), state_hash(alone.model, alone.state));
}

// Two threads may download the state at the same time.
TEST(DeviceState, ConcurrentDownloads) {
  OnDevice device;
  device.step();
  std::uint64_t hashes[2] = {};
  {
    std::jthread a([&] { hashes[0] = state_hash(device.model, device.state); });
    std::jthread b([&] { hashes[1] = state_hash(device.model, device.state); });
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Without a backend, the state steps on the host.
TEST(DeviceState, WithoutBackendStepsOnHost) {
  CutBlock block = cut_block(Method::kVbd);
  DeviceState state = block.state;
  state.step(kOne, block.model, {}, kDt), step(kOne, block.model, block.state, {}, kDt);
  EXPECT_EQ(state_hash(block.model, state), state_hash(block.model, block.state));
}

/// A state on the device with a wound, some frames after its last download.
struct WoundOnDevice : OnDevice {
  BladePath path;

  explicit WoundOnDevice(TissueLaw law) : OnDevice(law) {
    step();
    path = lay_blade(model, state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}}).value();
    EXPECT_GT(state.cut_edges(model, path, 0, 1, 1), 10);
    for (int n = 0; n < 5; n++) step();
  }
};

// Measures of a wound and its surface need the download of support nodes only.
TEST(DeviceState, WoundNeedsSupportNodesOnly) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    WoundOnDevice device(law);
    const BodySurface surface = build_surface(device.model, device.state.cuts());
    const std::vector<int> beside = wound_support_nodes(device.model, device.state.cuts(),
                                                        device.state.virtual_u(), surface, device.path, 1),
                           behind = support_nodes(device.model, device.state.cuts(), device.state.virtual_u(),
                                                  surface);
    EXPECT_GT(beside.size(), 10u);
    EXPECT_LT(beside.size(), behind.size() / 2);
    Transfers::uploaded = Transfers::downloaded = 0;
    const Wound found = device.state.read_wound_nodes(beside, [&](const State& state) {
      return measure_wound(device.model, state, surface, device.path, 1);
    });
    const std::size_t virtual_nodes = device.state.virtual_u().size() * sizeof(VirtualNodeDisplacement);
    EXPECT_EQ(Transfers::downloaded, beside.size() * sizeof(VectorPair) + virtual_nodes);
    EXPECT_EQ(Transfers::uploaded, beside.size() * sizeof(int));
    const TriMesh snapshot = device.state.read_wound_nodes(behind, [&](const State& state) {
      return deformed_surface(device.model, state, surface, Shown::kStretch);
    });
    EXPECT_TRUE(device.state.is_on_device());
    const State& all = device.state.host();
    const Wound right = measure_wound(device.model, all, surface, device.path, 1);
    EXPECT_GT(right.gape_max, 1e-4) << "m";
    EXPECT_EQ(found.gape_max, right.gape_max);
    EXPECT_EQ(found.edge_displacement, right.edge_displacement);
    EXPECT_EQ(found.opening_area, right.opening_area);
    const TriMesh now = deformed_surface(device.model, all, surface, Shown::kStretch);
    EXPECT_TRUE(snapshot.vertices == now.vertices && snapshot.normals == now.normals &&
                snapshot.scalars == now.scalars);
  }
}

// Measures and pictures read no node besides the support nodes.
TEST(DeviceState, OtherNodesAreNotRead) {
  WoundOnDevice device(TissueLaw::kSolid);
  State state = device.state.host();
  const BodySurface surface = build_surface(device.model, state.cuts);
  const auto beside =
      wound_support_nodes(device.model, state.cuts, state.motion.virtual_u, surface, device.path, 1);
  const auto behind = support_nodes(device.model, state.cuts, state.motion.virtual_u, surface);
  const Wound wound = measure_wound(device.model, state, surface, device.path, 1);
  const TriMesh snapshot = deformed_surface(device.model, state, surface, Shown::kDisplacement);
  const auto forget_all_but = [&](const std::vector<int>& nodes) {
    State some = state;
    const Real lost = std::numeric_limits<Real>::quiet_NaN();
    for (std::size_t s = 0; s < state.motion.u.x.size(); s++)
      if (!std::binary_search(nodes.begin(), nodes.end(), int(s))) some.motion.u.set(s, {lost, lost, lost});
    return some;
  };
  EXPECT_EQ(measure_wound(device.model, forget_all_but(beside), surface, device.path, 1).gape_max,
            wound.gape_max);
  EXPECT_EQ(deformed_surface(device.model, forget_all_but(behind), surface, Shown::kDisplacement).scalars,
            snapshot.scalars);
}

// The device finds the same surface samples in balls as a brute-force search.
TEST(DeviceState, SamplesInBallsMatchBruteForce) {
  OnDevice device;
  const Vec3 h = device.model.anatomy.lattice.spacing;
  std::vector<SurfaceSample> samples;
  for (int s = 0; s < slot_count(device.model.anatomy.lattice); s += 3)
    if (is_body(device.model.anatomy.tissue[std::size_t(s)])) {
      const Vec3d rest(
          rest_position(device.model.anatomy.lattice, slot_node(device.model.anatomy.lattice, s)));
      samples.push_back({s, rest + Vec3d{0.3 * double(h.x), 0, 0}, false, s % 2 == 0 ? s + 1 : -1});
    }
  std::vector<Ball> balls;
  balls.reserve(19);
  for (int b = 0; b < 19; b++)  // more than one launch handles, some of them overlapping
    balls.push_back({samples[std::size_t(b * 7) % samples.size()].rest, double(h.x) * (0.5 + 0.1 * b)});
  for (int n = 0; n < 3; n++) {
    device.step();
    std::vector<SurfaceSample> some(samples.begin(), samples.end() - n * 11);
    const std::vector<int> found = device.state.samples_in_balls(some, std::uint64_t(n + 1), balls);
    ASSERT_TRUE(device.state.is_on_device());
    EXPECT_GT(found.size(), 19u);
    EXPECT_LT(found.size(), some.size());
    EXPECT_EQ(found, samples_in_balls(some, device.state.host().motion, balls));
    EXPECT_EQ(found, device.state.samples_in_balls(some, std::uint64_t(n + 1), balls)) << "on the host";
    EXPECT_TRUE(device.state.samples_in_balls(some, std::uint64_t(n + 1), {}).empty());
  }
}

}  // namespace
}  // namespace turgor::lattice
