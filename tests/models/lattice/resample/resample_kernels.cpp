// The deformed CT by the device kernels, in any order, against that of the CPU.
#include "turgor/models/lattice/resample/resample_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/cut_ball.hpp"
#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);
constexpr ResampleOptions kAlone{.conserve_mass = false, .keep_surroundings = false};
/// Bytes that are uploaded and downloaded besides the voxels: the extent of the displacement, and the
/// counters.
constexpr std::size_t kOverhead = sizeof(MovedBits) + kCounterCount * sizeof(ResampleCounts);

/// A bent body; for large `fold` it overlaps itself.
State waved(const Model& model, double fold) {
  State state = make_state(model);
  move(model, state, [fold](Vec3d x) {
    return Vec3d{0.003 * std::sin(300 * x.y) + 0.0004, fold * std::sin(400 * x.x),
                 0.002 * std::cos(250 * x.z) - 0.001};
  });
  return state;
}

/// Rotated, left-handed, and with different spacings.
Grid other_grid(const Grid& ct) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  return {.size = {24, 35, 30},
          .spacing = {0.0011, 0.0007, 0.0013},
          .origin = ct.origin + Vec3d{0.002, 0.001, 0.045},
          .axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, -1}}}};
}

template <class R>
ResampledCt by_kernels(const Model& model, const State& state, const CtVolume& ct, const Grid& grid,
                       const ResampleOptions& options) {
  const std::shared_ptr<BodyBackend> device = put_on_host<R>(model);
  device->upload_state(model, state);
  const DeviceResampled made = device->resample(kExec, model, state.cuts, ct, grid, options).value();
  ResampledCt now{.ct = {.grid = grid, .samples = {}}, .report = made.report};
  now.ct.samples.resize(sample_count(grid));
  made.samples->download(now.ct.samples);
  return now;
}

/// Numbers of voxels that are not air, and of voxels that differ.
struct Compared {
  long tissue = 0, other = 0;
};
Compared compared(const CtVolume& device, const CtVolume& host) {
  Compared found;
  for (std::size_t v = 0; v < host.samples.size(); v++) {
    found.tissue += host.samples[v] != kAirHu;
    found.other += device.samples[v] != host.samples[v];
  }
  return found;
}

/// The kernels give the CT and the report of the CPU in any order.
void expect_ct_of_cpu(const Model& model, const State& state, const CtVolume& ct, const Grid& grid,
                      const ResampleOptions& options) {
  const auto by = [&]<class R>(R) { return by_kernels<R>(model, state, ct, grid, options); };
  const ResampledCt host = resample_ct(kExec, model, state, ct, grid, options);
  const ResampledCt one = by(SeededRun<1>{});
  for (const ResampledCt& other :
       {by(SeededRun<2>{}), by(ThreadedRun<1>{}), by(ThreadedRun<2>{}), by(ThreadedRun<8>{})}) {
    EXPECT_EQ(one.ct.samples, other.ct.samples);
    EXPECT_EQ(one.report.mass_error, other.report.mass_error);
  }
  EXPECT_EQ(one.report.inverted_tets, host.report.inverted_tets);
  EXPECT_EQ(one.report.overlaps, host.report.overlaps);
  EXPECT_NEAR(one.report.mass_error, host.report.mass_error, 1e-6);
  const Compared found = compared(one.ct, host.ct);
  EXPECT_GT(found.tissue, 1000);
#ifdef TURGOR_SAME_BITS
  EXPECT_EQ(found.other, 0);
#else
  EXPECT_LE(found.other, found.tissue / 2000)
      << "of " << found.tissue << " voxels: fused multiply-adds round differently";
#endif
}

// The deformed CT matches that of the CPU in any order of the loops.
TEST(ResampleKernels, CtMatchesCpuInAnyOrder) {
  const CtVolume ct = ball_ct(33, 12.3);
  long overlaps = 0;
  for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}})
    for (const double fold : {0.0, 0.004}) {
      const Model model = body_of(ct, block);
      const State state = waved(model, fold);
      for (const Grid& grid : {ct.grid, resized(ct.grid, {22, 30, 41}), other_grid(ct.grid)}) {
        overlaps += resample_ct(kExec, model, state, ct, grid, kAlone).report.overlaps;
        expect_ct_of_cpu(model, state, ct, grid, {.keep_surroundings = fold == 0});
      }
    }
  EXPECT_GT(overlaps, 500) << "voxels that several tetrahedra claim";
}

// The blur of the skin moves with the skin, and a table stays.
TEST(ResampleKernels, BlurMovesAndTableStays) {
  CtVolume ct = blurred_ball_ct(40, 12.4, true);
  for_voxels(ct.grid, [&](Int3 p) {  // a table and its cover
    if (p.y > 32 && p.y < 37) ct.at(p.x, p.y, p.z) = p.y == 33 ? -600 : std::int16_t(-300 + p.x);
  });
  for (const Int3 block : {Int3{2, 2, 2}, {3, 5, 4}}) {
    const Model model = body_of(ct, block);
    State state = make_state(model);
    expect_ct_of_cpu(model, state, ct, ct.grid, {});
    EXPECT_EQ(by_kernels<SeededRun<3>>(model, state, ct, ct.grid, {}).ct.samples, ct.samples) << "at rest";
    cut_across_y(model, state, 0.0203, [](Vec3d x) { return x.z > 0.012; });
    move(model, state, [&](Vec3d x) {
      return wobble(x, 0.001, 0.05, 0.3) + Vec3d{0.0003, x.y >= 0.0203 ? 0.0004 : -0.004, 0};
    });
    for (const Grid& grid : {ct.grid, resized(ct.grid, {27, 80, 40}), other_grid(ct.grid)})
      expect_ct_of_cpu(model, state, ct, grid, {});
  }
}

// A state on the device is resampled on the device, and only the CT is downloaded.
TEST(ResampleKernels, DeviceStateDownloadsCtOnly) {
  const CtVolume ct = ball_ct(33, 12);
  const Model model = body_of(ct, {3, 3, 3});
  DeviceState state = waved(model, 0);
  state.use_backend(put_on_host<SeededRun<1>>(model));
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  for (int n = 0; n < 2; n++) EXPECT_TRUE(state.step(kExec, model, inputs, 1e-3).finite);
  Transfers::uploaded = Transfers::downloaded = 0;
  const CtVolume now = state.resample(kExec, model, ct, ct.grid, kAlone).ct;
  EXPECT_EQ(Transfers::downloaded, now.samples.size() * sizeof(std::int16_t) + kOverhead);
  Transfers::uploaded = 0;
  (void)state.resample(kExec, model, ct, ct.grid, kAlone);
  EXPECT_EQ(Transfers::uploaded, kOverhead) << "the CT is already on the device";
  const CtVolume fetched = resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct;
  EXPECT_LE(compared(now, fetched).other, 8) << "voxels: fused multiply-adds round differently";
  EXPECT_EQ(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples, now.samples)
      << "on the host and on the device";
  state.change().motion.u.x[std::size_t(node_slot(model.anatomy.lattice, 5, 5, 5))] += 1e-4f;
  EXPECT_EQ(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples,
            resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct.samples)
      << "on the host only";
}

// The deformed CT of a body with fragments matches that of the CPU.
TEST(ResampleKernels, FragmentsMatchCpu) {
  for (const CutBall& ball : {CutBall({}), CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                              CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    const Fragments fragments = make_fragments(ball.model, ball.state.cuts);
    ASSERT_GT(fragments.virtual_nodes.size(), 20u);
    EXPECT_EQ(ball.state.motion.virtual_u.size() == fragments.virtual_nodes.size(),
              ball.model.params.tissue.law == TissueLaw::kSolid)
        << "virtual nodes are unknowns";
    expect_ct_of_cpu(ball.model, ball.state, ball.ct, ball.ct.grid, {.conserve_mass = true});
    expect_ct_of_cpu(ball.model, ball.state, ball.ct, other_grid(ball.ct.grid), kAlone);
  }
}

// The deformed CT of a body with removed nodes matches that of the CPU.
TEST(ResampleKernels, RemovedNodesMatchCpu) {
  CutBall ball({});
  ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
  expect_ct_of_cpu(ball.model, ball.state, ball.ct, ball.ct.grid, {});
  CutBall whole({});
  whole.state = make_state(whole.model);
  ASSERT_GT(cut_region(whole.model, whole.state, whole.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
  expect_ct_of_cpu(whole.model, whole.state, whole.ct, whole.ct.grid, {});
}

/// The kernels give the fields of the CPU in any order.
void expect_fields_of_cpu(const Model& model, const State& state, const Grid& grid) {
  const VectorVolume u = resample_displacement(kExec, model, state, grid);
  const ScalarVolume ratio = resample_jacobian(kExec, model, state, grid);
  const auto by = [&]<class R>(R) {
    const std::shared_ptr<BodyBackend> device = put_on_host<R>(model);
    device->upload_state(model, state);
    std::pair<std::vector<Vec3>, std::vector<float>> made(sample_count(grid), sample_count(grid));
    EXPECT_TRUE(device->download_displacement(model, state.cuts, grid, made.first));
    EXPECT_TRUE(device->download_jacobian(model, state.cuts, grid, made.second));
    return made;
  };
  const auto one = by(SeededRun<1>{});
  EXPECT_EQ(one, by(SeededRun<2>{}));
  EXPECT_EQ(one, by(ThreadedRun<8>{}));
  long tissue = 0, other = 0, wrong = 0;
  for (std::size_t v = 0; v < ratio.samples.size(); v++) {
    const float difference = norm(one.first[v] - u.samples[v]);
    const float ratio_difference =
        std::abs(one.second[v] - ratio.samples[v]) / std::max(1.0f, ratio.samples[v]);
    tissue += ratio.samples[v] != 1 || norm(u.samples[v]) > 0;
    other += difference > 1e-8f || ratio_difference > 1e-6f;
    wrong += difference > 2e-6f || ratio_difference > 5e-3f;
  }
  EXPECT_GT(tissue, 1000);
#ifdef TURGOR_SAME_BITS
  EXPECT_EQ(one.first, u.samples);
  EXPECT_EQ(one.second, ratio.samples);
#else
  EXPECT_LE(other, tissue / 50) << "of " << tissue
                                << " voxels: fused multiply-adds may shift a corner by a 1024th of a voxel";
  EXPECT_LE(wrong, tissue / 2000);
#endif
}

/// A CT with rotated axes and three different spacings.
CtVolume turned_ct(CtVolume ct) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  ct.grid.spacing = {0.0009, 0.0013, 0.0011};
  ct.grid.axes = {{{c, s, 0}, {-s * c, c * c, s}, {s * s, -c * s, c}}};
  return ct;
}

// Displacement and Jacobian fields match those of the CPU in any order of the loops.
TEST(ResampleKernels, FieldsMatchCpuInAnyOrder) {
  for (const CtVolume& ct : {ball_ct(33, 12.3), turned_ct(ball_ct(30, 11.2))})
    for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}})
      for (const double fold : {0.0, 0.004}) {
        const Model model = body_of(ct, block);
        const State state = waved(model, fold);
        for (const Grid& grid : {ct.grid, resized(ct.grid, {22, 30, 41}), other_grid(ct.grid)})
          expect_fields_of_cpu(model, state, grid);
      }
}

// Fields of a body with fragments match those of the CPU.
TEST(ResampleKernels, FieldsOfFragmentsMatchCpu) {
  for (CutBall& ball :
       std::vector{CutBall({}), CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                   CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    expect_fields_of_cpu(ball.model, ball.state, resized(ball.ct.grid, ball.ct.grid.size * 2));
    expect_fields_of_cpu(ball.model, ball.state, other_grid(ball.ct.grid));
    ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
    expect_fields_of_cpu(ball.model, ball.state, ball.ct.grid);
  }
}

// Only the requested field is downloaded.
TEST(ResampleKernels, OnlyRequestedFieldIsDownloaded) {
  CutBall ball({}, TissueLaw::kSolid);
  DeviceState state = ball.state;
  state.use_backend(put_on_host<SeededRun<1>>(ball.model));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const std::size_t voxels = sample_count(ball.ct.grid);
  Transfers::downloaded = 0;
  const VectorVolume u = state.resample_displacement(kExec, ball.model, ball.ct.grid);
  EXPECT_EQ(Transfers::downloaded, voxels * sizeof(Vec3) + sizeof(MovedBits));
  Transfers::uploaded = Transfers::downloaded = 0;
  const ScalarVolume ratio = state.resample_jacobian(kExec, ball.model, ball.ct.grid);
  EXPECT_EQ(Transfers::downloaded, voxels * sizeof(float) + sizeof(MovedBits));
  EXPECT_EQ(Transfers::uploaded, kOverhead) << "the fragments are on the device, and no CT was requested";
  const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone).ct;
  const CtVolume host = resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid, kAlone).ct;
  EXPECT_LE(compared(now, host).other, 8) << "then HU";
  const VectorVolume u_host = resample_displacement(kExec, ball.model, state, ball.ct.grid);
  const ScalarVolume ratio_host = resample_jacobian(kExec, ball.model, state, ball.ct.grid);
  for (std::size_t v = 0; v < voxels; v++) {
    ASSERT_LT(norm(u.samples[v] - u_host.samples[v]), 1e-8) << "m, voxel " << v;
    ASSERT_NEAR(ratio.samples[v], ratio_host.samples[v], 1e-6) << "voxel " << v;
  }
  state.change().motion.u.x[std::size_t(node_slot(ball.model.anatomy.lattice, 5, 5, 5))] += 1e-4f;
  EXPECT_EQ(state.resample_displacement(kExec, ball.model, ball.ct.grid).samples,
            resample_displacement(kExec, ball.model, state, ball.ct.grid).samples)
      << "on the host only";
}

/// A backend that limits the bytes of each array.
struct FullBackend {
  static inline std::size_t limit = 0;
  template <class T>
  struct Array : CountedArray<T> {
    Array() = default;
    explicit Array(std::size_t count)
        : CountedArray<T>(count * sizeof(T) <= limit ? count : 0), wanted(count) {}
    bool is_allocated() const { return wanted * sizeof(T) <= limit; }
    std::size_t wanted = 0;
  };
  using Run = SeededRun<1>;
};

// Without enough device memory, the CPU computes the result.
TEST(ResampleKernels, FallsBackToCpuWithoutMemory) {
  const CutBall ball({});
  FullBackend::limit = 1000000000;
  DeviceAllocator<FullBackend> allocator;
  DeviceState state = ball.state;
  state.use_backend(std::make_shared<DeviceBody<FullBackend>>(ball.model, allocator));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const Grid& grid = ball.ct.grid;
  const std::size_t voxels = sample_count(grid);
  const CtVolume ct = resample_ct(kExec, ball.model, state, ball.ct, grid).ct;
  const VectorVolume u = resample_displacement(kExec, ball.model, state, grid);
  const ScalarVolume ratio = resample_jacobian(kExec, ball.model, state, grid);
  for (const auto& [limit, u_back, ratio_back, ct_back] :
       {std::tuple(100 * voxels, 12 * voxels, 4 * voxels, 2 * voxels),
        {8 * voxels, 0, 4 * voxels, 2 * voxels},
        {std::size_t(100), 0, 0, 0},
        {100 * voxels, 12 * voxels, 4 * voxels, 2 * voxels}}) {
    FullBackend::limit = limit;
    const auto back_of = [&](const auto& make) {
      Transfers::downloaded = 0;
      make();
      return Transfers::downloaded - Transfers::downloaded % voxels;  // ignores the bytes besides the voxels
    };
    std::vector<Vec3> u_now;
    std::vector<float> ratio_now;
    std::vector<std::int16_t> ct_now;
    EXPECT_EQ(back_of([&] { u_now = state.resample_displacement(kExec, ball.model, grid).samples; }), u_back);
    EXPECT_EQ(back_of([&] { ratio_now = state.resample_jacobian(kExec, ball.model, grid).samples; }),
              ratio_back);
    EXPECT_EQ(back_of([&] { ct_now = state.resample(kExec, ball.model, ball.ct, grid).ct.samples; }),
              ct_back);
    EXPECT_TRUE(u_back > 0 || u_now == u.samples);
    EXPECT_TRUE(ratio_back > 0 || ratio_now == ratio.samples);
    EXPECT_TRUE(ct_back > 0 || ct_now == ct.samples);
  }
}

// Output grids one voxel thick across a wound match the CPU.
TEST(ResampleKernels, SingleSlicesAcrossWound) {
  const CutBall ball({}, TissueLaw::kSolid);
  const Vec3d top = point_at(ball.ct.grid, {16, 16, 27});
  for (int axis = 0; axis < 3; axis++) {
    Grid grid{.size = {90, 90, 90}, .spacing = {2.5e-4, 2.5e-4, 2.5e-4}, .origin = {}, .axes = {}};
    grid.origin = top - Vec3d{0.011, 0.011, 0.011};
    grid.origin[axis] = top[axis], grid.size[axis] = 1;
    expect_ct_of_cpu(ball.model, ball.state, ball.ct, grid, {});
  }
}

// A deformed CT that is still referenced keeps its values after the next one.
TEST(ResampleKernels, HeldCtOutlivesNextOne) {
  const CtVolume ct = ball_ct(25, 9);
  const Model model = body_of(ct, {3, 3, 3});
  DeviceState state = waved(model, 0);
  state.use_backend(put_on_host<SeededRun<1>>(model));
  EXPECT_TRUE(state.step(kExec, model, {}, 1e-3).finite);
  const auto first = state.resample_on_device(kExec, model, ct, ct.grid, kAlone);
  ASSERT_TRUE(first);
  std::vector<std::int16_t> before(ct.samples.size()), after = before;
  first->samples->download(before);
  for (int n = 0; n < 3; n++) EXPECT_TRUE(state.step(kExec, model, {.gravity = {0, 0, -9.81}}, 1e-2).finite);
  EXPECT_NE(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples, before) << "the body moves";
  first->samples->download(after);
  EXPECT_EQ(after, before);
}

// A body without stiffness is resampled by the CPU.
TEST(ResampleKernels, FallsBackToCpuWithoutStiffness) {
  CutBall ball({.method = Method::kPbd, .pbd_stiffness = 0});
  DeviceState state = ball.state;
  state.use_backend(put_on_host<SeededRun<1>>(ball.model));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid).ct;
  EXPECT_EQ(now.samples, resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid).ct.samples);
  EXPECT_GT(std::count_if(now.samples.begin(), now.samples.end(), [](int hu) { return hu > -200; }), 5000);
}

// The deformed CT of a wound follows the blade on the device.
TEST(ResampleKernels, CtFollowsBlade) {
  CutBall ball({});
  DeviceState state = ball.state;
  state.use_backend(put_on_host<SeededRun<1>>(ball.model));
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  EXPECT_TRUE(state.step(kExec, ball.model, inputs, 1e-3).finite);
  for (int n = 0; n < 2; n++) {
    Transfers::downloaded = 0;
    const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone).ct;
    EXPECT_EQ(Transfers::downloaded, now.samples.size() * sizeof(std::int16_t) + kOverhead) << "but no state";
    const CtVolume host = resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid, kAlone).ct;
    EXPECT_LE(compared(now, host).other, 8) << "voxels: fused multiply-adds round differently";
    Transfers::uploaded = 0;
    (void)state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone);
    EXPECT_EQ(Transfers::uploaded, kOverhead) << "the fragments are already on the device";
    if (n > 0) break;
    EXPECT_GT(state.cut_edges(ball.model, ball.path({-6, -5, 0}, {6, -4, 0}, 10, 0), 0, 1, 1), 5);
    for (int k = 0; k < 3; k++) EXPECT_TRUE(state.step(kExec, ball.model, inputs, 2e-3).finite);
  }
}

}  // namespace
}  // namespace turgor::lattice
