// Tissue on fixed bone: the bone begins between the nodes, where the CT shows it.
#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr int kWide = 42;  // cells: wide enough that the rim does not affect the center

/// A layer of fat on bone, both as wide as the CT except for its rim, with the normal along `axis` and
/// `steps` cells of fat.
Model layer_on_bone(int axis, int steps, Int3 block, double poisson) {
  Int3 size{kWide, kWide, kWide};
  size[axis] = steps + 4;
  CtVolume ct = make_ct(hadamard(size, block), [](Vec3d) { return false; });
  for (int k = 0; k < ct.grid.size.z; k++)
    for (int j = 0; j < ct.grid.size.y; j++)
      for (int i = 0; i < ct.grid.size.x; i++) {
        const Int3 p{i / block.x, j / block.y, k / block.z};
        bool inside = true;
        for (int a = 0; a < 3; a++) inside = inside && p[a] > 0 && p[a] < size[a] - 1;
        if (inside) ct.at(i, j, k) = p[axis] <= steps ? -100 : 900;
      }
  Params params;
  params.block = block;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.poisson = poisson;
  params.solver = {.sweeps = 20, .damping = 8};
  return build(Exec(2), ct, {}, params).value();
}

/// Nodes at the center of the layer: the outermost one of fat, and the first fixed one.
struct Column {
  int front = 0, held = 0;
};
Column middle_column(const Model& model, int axis) {
  const auto slot = [&](int at) {
    Int3 p{kWide / 2, kWide / 2, kWide / 2};
    p[axis] = at;
    return std::size_t(node_slot(model.anatomy.lattice, p));
  };
  Column column;
  while (!is_body(model.anatomy.tissue[slot(column.front)])) column.front++;
  for (column.held = column.front; model.anatomy.inverse_mass[slot(column.held)] > 0;) column.held++;
  return column;
}

/// Displacement at rest of the front's center under a pressure [m].
double settled(const Model& model, int axis, int front, double pressure) {
  const Lattice& l = model.anatomy.lattice;
  const double area = l.spacing.x * l.spacing.y * l.spacing.z / l.spacing[axis];
  std::vector<NodeLoad> loads;
  int middle = -1;
  for (int b = 0; b < kWide; b++)
    for (int a = 0; a < kWide; a++) {
      Int3 p;
      p[axis] = front, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
      const int slot = node_slot(l, p);
      if (a == kWide / 2 && b == kWide / 2) middle = slot;
      if (!is_body(model.anatomy.tissue[std::size_t(slot)])) continue;
      Vec3 force;
      force[axis] = Real(pressure * area);
      loads.push_back({slot, force});
    }
  State state = make_state(model);
  for (int n = 0; n < 60; n++) step(Exec(2), model, state, {.loads = loads}, 1.0 / 60);
  return double(state.motion.u[std::size_t(middle)][axis]);
}

// A wide layer on bone yields by its thickness in the CT, in every direction.
TEST(LatticeOnBone, WideLayerYieldsByItsThickness) {
  struct Case {
    int axis, steps;
    Int3 block;
    double poisson, pressure;  // [1], [Pa], negative pressure pulls
  };
  for (const Case& c :
       {Case{0, 4, {1, 1, 1}, 0.4, 50}, Case{1, 3, {2, 1, 1}, 0.3, -60}, Case{2, 4, {1, 1, 2}, 0.25, 40}}) {
    const Model model = layer_on_bone(c.axis, c.steps, c.block, c.poisson);
    const Column column = middle_column(model, c.axis);
    ASSERT_EQ(column.held, c.steps + 1) << "boundary between fat and bone";
    const double thickness = (column.held - column.front) * double(model.anatomy.lattice.spacing[c.axis]);
    const double modulus =
        model.params.tissue.fat * (1 - c.poisson) / ((1 + c.poisson) * (1 - 2 * c.poisson));
    const double expected = c.pressure * thickness / modulus;
    EXPECT_NEAR(settled(model, c.axis, column.front, c.pressure) / expected, 1, 0.02)
        << "axis " << c.axis << ", " << column.held - column.front << " steps, of " << expected << " m";
  }
}

}  // namespace
}  // namespace turgor::lattice
