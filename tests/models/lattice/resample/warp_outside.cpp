// The exported displacement field gives the deformed CT when another program warps the CT with it. The warp
// here is that of ITK (WarpImageFilter, ResampleImageFilter), written from its definition: output(p) =
// input(p + field(p)), linear between voxels, air outside of the image.
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/resample/image_mass.hpp"
#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);

/// Linear interpolation at a physical point [m].
double value_at(const CtVolume& ct, Vec3d point) {
  const Vec3d local = transposed(ct.grid.axes) * (point - ct.grid.origin);
  Int3 low;
  Vec3d fraction;
  for (int axis = 0; axis < 3; axis++) {
    const double index = local[axis] / ct.grid.spacing[axis];
    if (index < -1e-6 || index > ct.grid.size[axis] - 1 + 1e-6) return kAirHu;
    low[axis] = std::clamp(int(std::floor(index)), 0, ct.grid.size[axis] - 2);
    fraction[axis] = std::clamp(index - low[axis], 0.0, 1.0);
  }
  double sum = 0;
  for (int c = 0; c < 8; c++) {
    double weight = 1;
    Int3 at = low;
    for (int axis = 0; axis < 3; axis++) {
      const int up = c >> axis & 1;
      weight *= up ? fraction[axis] : 1 - fraction[axis];
      at[axis] += up;
    }
    sum += weight * ct.at(at.x, at.y, at.z);
  }
  return sum;
}

/// Voxels in which the warped CT differs from another by more than a HU.
long different_voxels(const CtVolume& ct, const VectorVolume& field, const CtVolume& other) {
  long different = 0;
  for_voxels(field.grid, [&](Int3 p) {
    const Vec3d from = point_at(field.grid, Vec3d(p)) + Vec3d(field.at(p.x, p.y, p.z));
    different += std::abs(value_at(ct, from) - other.at(p.x, p.y, p.z)) > 1.01;
  });
  return different;
}

/// A field and its body.
struct Moved {
  CtVolume ct, now;
  VectorVolume warp, tissue_only;
};
Moved moved_by(CtVolume ct, const std::function<Vec3d(Vec3d)>& displacement) {
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  move(model, state, displacement);
  CtVolume now = resample_ct(kExec, model, state, ct, ct.grid).ct;
  return {ct, now, resample_warp(kExec, model, state, ct.grid),
          resample_displacement(kExec, model, state, ct.grid)};
}

Vec3d shift(Vec3d) { return Vec3d{3.4, -2.2, 1.7} * kVoxel; }
Vec3d stretch(Vec3d p) {
  return {0.2 * (p.x - 0.026) + 0.1 * (p.y - 0.026), -0.1 * (p.y - 0.026), 0.15 * (p.z - 0.026)};
}

// The warp of the CT with the exported field is the deformed CT, at the border of air too.
TEST(WarpOutside, ItkWarpEqualsDeformedCt) {
  for (const auto& displacement : {shift, stretch}) {
    const Moved moved = moved_by(blurred_ball_ct(52, 15.3, false), displacement);
    const long tissue_only = different_voxels(moved.ct, moved.tissue_only, moved.now);
    const long different = different_voxels(moved.ct, moved.warp, moved.now);
    std::printf("voxels in which ITK's warp differs: %ld, with the field of the tissue alone %ld\n",
                different, tissue_only);
    EXPECT_GT(tissue_only, 500) << "the body left them, and the warp shows it there still";
    EXPECT_LE(different, 5);
  }
}

// In a wound the warp shows air, as the deformed CT does.
TEST(WarpOutside, WoundIsAir) {
  const CtVolume ct =
      make_ct({64, 64, 40}, [](Vec3d p) { return p.x > 5 && p.x < 58 && p.y > 5 && p.y < 58 && p.z < 30; });
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  cut_across_y(model, state, 0.0313, [](Vec3d p) { return p.z > 0.019; });
  move(model, state, [](Vec3d p) {  // opens from the bottom to the skin
    const double open = 0.004 * std::clamp((p.z - 0.015) / 0.014, 0.0, 1.0) *
                        std::max(0.0, 1 - std::abs(p.y - 0.0313) / 0.024);
    return Vec3d{0, p.y >= 0.0313 ? open : -open, 0};
  });
  const CtVolume now = resample_ct(kExec, model, state, ct, ct.grid).ct;
  const VectorVolume warp = resample_warp(kExec, model, state, ct.grid);
  long air = 0;
  for_voxels(ct.grid,
             [&](Int3 p) { air += now.at(p.x, p.y, p.z) == kAirHu && ct.at(p.x, p.y, p.z) != kAirHu; });
  EXPECT_GT(air, 1000) << "voxels of the wound";
  const long different = different_voxels(ct, warp, now);
  std::printf("wound of %ld voxels: ITK's warp differs in %ld\n", air, different);
  EXPECT_LE(different, air / 100);
}

// At the border of air, the deformed CT is that of the moved body, within the linear interpolation.
TEST(WarpOutside, DeformedCtIsThatOfMovedBody) {
  const Moved moved = moved_by(blurred_ball_ct(52, 15.3, false), shift);
  long wrong = 0;
  for_voxels(moved.ct.grid, [&](Int3 p) {
    const Vec3d from = point_at(moved.ct.grid, Vec3d(p)) - shift({});
    wrong += std::abs(value_at(moved.ct, from) - moved.now.at(p.x, p.y, p.z)) > 1.01;
  });
  EXPECT_LE(wrong, 5);
}

// A field at rest is zero, and a voxel far from the body keeps a displacement of zero.
TEST(WarpOutside, FarAndRestingVoxelsStay) {
  const Moved rest = moved_by(blurred_ball_ct(52, 15.3, true), [](Vec3d) { return Vec3d{}; });
  for (const Vec3 u : rest.warp.samples) ASSERT_LT(norm(u), 1e-7f) << "m";
  EXPECT_EQ(moved_by(blurred_ball_ct(52, 15.3, false), shift).warp.at(1, 1, 1), Vec3{});
}

/// Σ (HU + 1000) of a volume.
double mass_of(const CtVolume& ct) {
  double sum = 0;
  for (const std::int16_t hu : ct.samples) sum += hu + 1000.0;
  return sum;
}

// The mass error of a moved body is that of the whole image. That of the tissue's voxels alone is another.
TEST(WarpOutside, MassErrorIsThatOfImage) {
  const CtVolume ct = blurred_ball_ct(52, 15.3, false);
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  move(model, state, [](Vec3d p) {
    return Vec3d{0, 0.06 * (p.x - 0.026), 0} + Vec3d{0.4, 0.3, 0.2} * kVoxel;
  });
  const ResampledCt now = resample_ct(kExec, model, state, ct, ct.grid);
  const double error = image_mass_error(kExec, model, make_state(model), ct, now.ct);
  EXPECT_NEAR(error, mass_of(now.ct) / mass_of(ct) - 1, 1e-4) << "nothing but the body is in the image";
  EXPECT_LT(std::abs(error), 1e-3) << "a shear conserves the volume";
}

// Tissue that a blade removed is no error of the mass.
TEST(WarpOutside, RemovedTissueIsNoMassError) {
  const CtVolume ct = make_ct({40, 40, 40}, [](Vec3d p) { return p.z < 30; });
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  remove_block(model, state);
  const CtVolume now = resample_ct(kExec, model, state, ct, ct.grid).ct;
  EXPECT_LT(mass_of(now), 0.99 * mass_of(ct));
  EXPECT_NEAR(image_mass_error(kExec, model, state, ct, now), 0, 1e-12);
}

}  // namespace
}  // namespace turgor::lattice
