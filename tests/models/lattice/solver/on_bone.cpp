// Tissue on bone that is held: the bone begins where the CT shows it, between the nodes.
#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"

namespace turgor::lattice {
namespace {

constexpr int kWide = 42;  // steps: the middle of a layer does not feel its rim

/// A layer of fat on bone, both as wide as the CT but for its rim; which axis is its normal, and how many
/// steps of fat there are.
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

/// The nodes in the middle of the layer: the outermost of fat, and the first that is held.
struct Column {
  int front = 0, held = 0;
};
Column middle_column(const Model& model, int axis) {
  const auto slot = [&](int at) {
    Int3 p{kWide / 2, kWide / 2, kWide / 2};
    p[axis] = at;
    return std::size_t(node_slot(model.lattice, p));
  };
  Column column;
  while (!is_body(model.tissue[slot(column.front)])) column.front++;
  for (column.held = column.front; model.inverse_mass[slot(column.held)] > 0;) column.held++;
  return column;
}

/// How far the middle of its front comes to rest under a pressure [m].
double settled(const Model& model, int axis, int front, double pressure) {
  const Lattice& l = model.lattice;
  const double area = l.step.x * l.step.y * l.step.z / l.step[axis];
  std::vector<NodeLoad> loads;
  int middle = -1;
  for (int b = 0; b < kWide; b++)
    for (int a = 0; a < kWide; a++) {
      Int3 p;
      p[axis] = front, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
      const int slot = node_slot(l, p);
      if (a == kWide / 2 && b == kWide / 2) middle = slot;
      if (!(model.inverse_mass[std::size_t(slot)] > 0)) continue;
      Vec3 force;
      force[axis] = Real(pressure * area);
      loads.push_back({slot, force});
    }
  State state = make_state(model);
  for (int n = 0; n < 60; n++) step(Exec(2), model, state, {.loads = loads}, 1.0 / 60);
  return double(state.u[std::size_t(middle)][axis]);
}

TEST(lattice_on_bone, a_wide_layer_gives_way_by_its_thickness_in_the_ct_in_every_direction) {
  struct Case {
    int axis, steps;
    Int3 block;
    double poisson, pressure;  // [1], [Pa], less than 0 pulls
  };
  for (const Case& c :
       {Case{0, 4, {1, 1, 1}, 0.4, 50}, Case{1, 3, {2, 1, 1}, 0.3, -60}, Case{2, 4, {1, 1, 2}, 0.25, 40}}) {
    const Model model = layer_on_bone(c.axis, c.steps, c.block, c.poisson);
    const Column column = middle_column(model, c.axis);
    ASSERT_EQ(column.held, c.steps + 1) << "where fat ends and bone begins";
    const double thickness = (column.held - column.front) * double(model.lattice.step[c.axis]);
    const double modulus =
        model.params.tissue.fat * (1 - c.poisson) / ((1 + c.poisson) * (1 - 2 * c.poisson));
    const double expected = c.pressure * thickness / modulus;
    EXPECT_NEAR(settled(model, c.axis, column.front, c.pressure) / expected, 1, 0.02)
        << "axis " << c.axis << ", " << column.held - column.front << " steps, of " << expected << " m";
  }
}

}  // namespace
}  // namespace turgor::lattice
