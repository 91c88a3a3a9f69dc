// A ball pressed into a body with partial cells has its force with few sweeps a frame, in every order of the
// CT's axes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {
namespace {

constexpr double kVoxel = 1e-3, kRadius = 0.007, kDepth = 0.006, kFrame = 1.0 / 60;
constexpr std::array<int, 3> kSize{42, 52, 37};  // of the CT along x, y, z of the patient [voxels]
constexpr int kAir = 6, kBone = 4;               // around the block; at its bottom [voxels]

/// Order in which a CT stores the patient: its axis a runs along axis along[a] of the patient, or against it.
struct Storage {
  std::array<int, 3> along, sign;
};

/// A block of soft tissue on bone, in air.
CtVolume stored_block(const Storage& storage) {
  CtVolume ct;
  for (int a = 0; a < 3; a++) {
    const auto patient = std::size_t(storage.along[std::size_t(a)]);
    ct.grid.size[a] = kSize[patient];
    ct.grid.spacing[a] = kVoxel;
    Vec3d axis;
    axis[int(patient)] = storage.sign[std::size_t(a)];
    ct.grid.axes.column[a] = axis;
    if (storage.sign[std::size_t(a)] < 0) ct.grid.origin[int(patient)] = (kSize[patient] - 1) * kVoxel;
  }
  for (int k = 0; k < ct.grid.size.z; k++)
    for (int j = 0; j < ct.grid.size.y; j++)
      for (int i = 0; i < ct.grid.size.x; i++) {
        const Vec3d x = point_at(ct.grid, {double(i), double(j), double(k)});
        bool inside = true;
        for (int a = 0; a < 3; a++) {
          const int voxel = int(std::lround(x[a] / kVoxel));
          inside = inside && voxel >= kAir && voxel < kSize[std::size_t(a)] - kAir;
        }
        const bool is_bone = std::lround(x.z / kVoxel) < kAir + kBone;
        ct.samples.push_back(std::int16_t(!inside ? -1000 : is_bone ? 1000 : 40));
      }
  return ct;
}

constexpr int kPress = 18, kWait = 42, kRest = 48;  // frames of the press, of a pause, and of the mean

/// Force along the press after each frame [N], and contacts in the last one.
struct Press {
  std::vector<double> forces = {};
  int contacts = 0;

  double mean() const { return std::accumulate(forces.end() - kRest, forces.end(), 0.0) / kRest; }
  double spread() const {
    const auto [least, most] = std::minmax_element(forces.end() - kRest, forces.end());
    return *most - *least;
  }
};

Press press(const Storage& storage, int block, int sweeps) {
  const CtVolume ct = stored_block(storage);
  lattice::Params params;
  params.block = {block, block, block};
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.tissue.partial_cells = true;
  params.tissue.fat = params.tissue.muscle = 8e3;
  params.solver.sweeps = sweeps;
  const lattice::Model model = lattice::build(Exec(2), ct, lattice::BodyFields{}, params).value();
  lattice::State state = lattice::make_state(model);
  const lattice::BodySurface surface =
      lattice::build_surface(model, state.cuts, &ct, lattice::Extent::kAll, Exec(2));
  const double top = (kSize[2] - kAir) * kVoxel - 0.5 * kVoxel;
  const Vec3d above{0.0205, 0.0255, top + kRadius};
  const std::vector<Tool> tools{{Sphere{kRadius}, 0.3}};
  std::vector<ToolPose> at{{{above, {}}, false}};
  std::vector<ToolForce> forces{1};
  LatticeTouch touch = make_lattice_touch(model, state.cuts, surface, at);
  // press and hold
  Press done;
  for (int n = 1; n <= kPress + kWait + kRest; n++) {
    at[0].pose.position = above - Vec3d{0, 0, kDepth * std::min(1.0, double(n) / kPress)};
    EXPECT_TRUE(step_with_tools(Exec(2), model, state, touch, tools, at, {}, kFrame, forces).finite);
    done.forces.push_back(forces[0].force.z);
  }
  done.contacts = forces[0].contacts;
  return done;
}

constexpr Storage kStorages[] = {{{0, 1, 2}, {1, 1, 1}},  {{1, 0, 2}, {1, 1, 1}},  {{2, 1, 0}, {1, 1, 1}},
                                 {{0, 2, 1}, {1, 1, -1}}, {{1, 2, 0}, {-1, 1, 1}}, {{2, 0, 1}, {-1, -1, -1}}};

/// Presses with the sweeps of a scene's default and with many, and compares the force and its largest
/// difference during the press.
void expect_converged(const Storage& storage, int block) {
  const Press few = press(storage, block, lattice::SolverParams{}.sweeps), many = press(storage, block, 60);
  double farthest = 0;
  for (std::size_t n = 0; n < few.forces.size(); n++)
    farthest = std::max(farthest, std::abs(few.forces[n] - many.forces[n]));
  std::printf("%d mm: %.4f N ± %.4f, %d contacts; with 60 sweeps %.4f N ± %.4f, at most %.4f N apart\n",
              block, few.mean(), 0.5 * few.spread(), few.contacts, many.mean(), 0.5 * many.spread(),
              farthest);
  EXPECT_NEAR(few.mean(), many.mean(), 0.01 * many.mean()) << "N";
  EXPECT_LT(few.spread(), 0.01 * many.mean()) << "N";
  EXPECT_LT(farthest, 0.03 * many.mean()) << "N";
}

// When each corner of a cell took the whole gap, the force at rest ranged from 1.1 to 2.6 N in the first
// order.
TEST(FewSweepPress, ConvergesInEveryOrderOfAxes) {
  for (const Storage& storage : kStorages) expect_converged(storage, 2);
}

// Forces travel through more cells in a frame.
TEST(FewSweepPress, ConvergesInFineCells) { expect_converged(kStorages[4], 1); }

}  // namespace
}  // namespace turgor::contact
