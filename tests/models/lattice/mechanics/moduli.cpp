// Stiffness in pascals: springs and volume constraints have the moduli they were calibrated for.
#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

/// Displaces the fixed right face, settles the remaining nodes and returns the energy [J].
double settled_energy(Model& model, Vec3 face_shift) {
  model.params.solver = {.sweeps = 20, .damping = 8};
  State state = make_state(model);
  const Int3 size = model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Real fraction = Real(i) / Real(size.x - 1);
        state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, i, j, k)), face_shift * fraction);
      }
  for (int n = 0; n < 150; n++) step(Exec(2), model, state, {}, 1.0 / 60);
  return energy(Exec(1), model, state);
}

Model bar(Int3 size, double volume) {
  Params params;
  params.skin.enabled = false;
  params.tissue.volume = volume;
  Block block{.size = size, .young = 1e4, .skin_on_top = false};
  block.is_fixed = [size](Int3 p) { return p.x == 0 || p.x == size.x - 1; };
  return block_model(block, params);
}

// A stretched bar has its Young's modulus within 10 %.
TEST(LatticeModuli, StretchedBarHasYoungsModulus) {
  for (const double volume : {0.0, 3.0}) {
    const Int3 size{97, 13, 13};  // long: the held ends prevent lateral contraction
    Model model = bar(size, volume);
    const double length = (size.x - 1) * 0.004, area = size.y * size.z * 0.004 * 0.004,
                 stretch = 0.01 * length;
    const double young =
        2 * settled_energy(model, {Real(stretch), 0, 0}) * length / (stretch * stretch * area);
    EXPECT_NEAR(young, 1e4, 1e3) << "Pa, volume energy " << volume;
  }
}

// A sheared plate has its shear modulus within 10 %.
TEST(LatticeModuli, ShearedPlateHasShearModulus) {
  const Int3 size{7, 61, 61};  // wide: the free sides carry less
  Model model = bar(size, 0);
  const double height = (size.x - 1) * 0.004, area = size.y * size.z * 0.004 * 0.004, shift = 0.01 * height;
  const double shear = 2 * settled_energy(model, {0, Real(shift), 0}) * height / (shift * shift * area);
  EXPECT_NEAR(shear, 0.4e4, 0.4e3) << "Pa: E / 2(1 + 1/4)";
}

// Calibrated springs have the requested shear moduli for any spacing of the lattice.
TEST(LatticeModuli, CalibrationOnAnySpacing) {
  for (const Vec3 h : {Vec3{1, 1, 1}, {0.78f, 0.78f, 1.25f}, {1, 1, 3}, {1, 1, 0.5f}, {1, 1.3f, 2}})
    for (const double volume : {0.0, 2.0}) {
      const auto scale = calibrate_springs(h, volume);
      for (const Real s : scale) EXPECT_GT(s, 0);
      const auto c = homogenized_stiffness(h, scale, volume);
      for (std::size_t axis = 3; axis < 6; axis++) EXPECT_NEAR(c[axis][axis], 0.4, 1e-4);
    }
}

}  // namespace
}  // namespace turgor::lattice
