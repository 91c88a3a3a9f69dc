// Layers of tissue below the skin: depths, means of layers that share a cell, and pressed slabs.
#include "turgor/models/lattice/build/cell_laws.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

const Exec kBoth(2);

// Layers that share a cell act in series: compliances add, under shear and under a press of a wide slab.
TEST(CellLaws, LayersOfCellActInSeries) {
  const std::vector<TissueLayer> layers = {
      {"skin", 0.002, {}, 2e5, 0.4, 1}, {"fat", 0.005, {}, 3e3, 0.45, 5}, {"rest", 0, {}, 2e4, 0.3, 9}};
  const LayerMean alone = mean_of_layers(layers, 0.003, 0.006);
  EXPECT_NEAR(alone.young, 3e3, 1e-6);
  EXPECT_NEAR(alone.poisson, 0.45, 1e-9);
  EXPECT_NEAR(alone.stiffening, 5, 1e-9);
  const LayerMean deep = mean_of_layers(layers, 0.05, 0.06);
  EXPECT_NEAR(deep.young, 2e4, 1e-6);
  // 0.5 mm of skin, 2.5 mm of fat
  const LayerMean mixed = mean_of_layers(layers, 0.0015, 0.0045);
  const auto shear = [](double young, double poisson) { return young / (2 * (1 + poisson)); };
  const auto confined = [](double young, double poisson) {
    return young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
  };
  EXPECT_NEAR(1 / shear(mixed.young, mixed.poisson), (0.5 / shear(2e5, 0.4) + 2.5 / shear(3e3, 0.45)) / 3,
              1e-9);
  EXPECT_NEAR(1 / confined(mixed.young, mixed.poisson),
              (0.5 / confined(2e5, 0.4) + 2.5 / confined(3e3, 0.45)) / 3, 1e-9);
}

/// A slab of layers with ν = 0 below outside air, on fixed nodes.
Model layered_slab(double spacing, int cells, const std::vector<TissueLayer>& layers) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.poisson = 0;
  params.tissue.layers = layers;
  params.solver = {.sweeps = 20, .damping = 8};
  Block block{.size = {4, 5, cells + 1}, .spacing = spacing, .young = params.tissue.muscle};
  block.is_fixed = [](Int3 p) { return p.z == 0; };
  return block_model(block, params);
}

// A pressed slab yields as its layers in series, for thicknesses that are no multiples of the spacing.
TEST(CellLaws, PressedSlabIsSpringsInSeries) {
  const std::vector<TissueLayer> layers = {
      {"skin", 0.0017, {}, 4e4, 0, 0}, {"fat", 0.0061, {}, 4e3, 0, 0}, {"muscle", 0, {}, 1.5e4, 0, 0}};
  for (const auto& [spacing, cells] : {std::pair{0.004, 5}, {0.0025, 8}}) {
    const Model model = layered_slab(spacing, cells, layers);
    const double pressure = 40, depth = spacing * cells;
    const double expected = pressure * (0.0017 / 4e4 + 0.0061 / 4e3 + (depth - 0.0078) / 1.5e4);
    std::vector<NodeLoad> loads;
    const Int3 size{4, 5, cells + 1};
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const double share =
            (i == 0 || i == size.x - 1 ? 0.5 : 1.0) * (j == 0 || j == size.y - 1 ? 0.5 : 1.0);
        loads.push_back({node_slot(model.anatomy.lattice, {i, j, cells}),
                         {0, 0, Real(-pressure * share * spacing * spacing)}});
      }
    State state = make_state(model);
    for (int n = 0; n < 60; n++) step(kBoth, model, state, {.loads = loads}, 1.0 / 60);
    const double top = double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, {2, 2, cells}))].z);
    EXPECT_NEAR(-top / expected, 1, 0.01) << "spacing " << spacing;
  }
}

// A slab whose upper layers slide on a thin one yields to a shear traction by the sum of the compliances of
// its layers in shear, in series: u = τ Σ t/(slide G), also where the sliding layer is thinner than a cell.
// In the middle of a long slab, away from its free ends, the shear is simple.
TEST(CellLaws, ShearedSlabSlidesInSeries) {
  constexpr double kYoung = 2e4, kSpacing = 0.004;
  constexpr int kCells = 5;
  const Int3 size{41, 4, kCells + 1};
  const auto shear_modulus = [](double young) { return young / 2; };  // ν = 0
  std::vector<double> tops;
  for (const double slide : {1.0, 0.2, 0.05}) {
    Params params;
    params.skin.enabled = false;
    params.tissue.law = TissueLaw::kSolid;
    params.tissue.poisson = 0;
    params.tissue.layers = {
        {.name = "skin", .thickness = 0.006, .young = kYoung, .poisson = 0},
        {.name = "fascia", .thickness = 0.001, .young = 1e4, .poisson = 0, .slide = slide},
        {.name = "muscle", .young = kYoung, .poisson = 0}};
    params.solver = {.sweeps = 30, .damping = 8};
    Block block{.size = size, .spacing = kSpacing, .young = kYoung};
    block.is_fixed = [](Int3 p) { return p.z == 0; };
    const Model model = block_model(block, params);
    // traction along x on the top
    const double traction = 10;  // [Pa]
    std::vector<NodeLoad> loads;
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const double share =
            (i == 0 || i == size.x - 1 ? 0.5 : 1.0) * (j == 0 || j == size.y - 1 ? 0.5 : 1.0);
        loads.push_back({node_slot(model.anatomy.lattice, {i, j, kCells}),
                         {Real(traction * share * kSpacing * kSpacing), 0, 0}});
      }
    State state = make_state(model);
    for (int n = 0; n < 120; n++) step(kBoth, model, state, {.loads = loads}, 1.0 / 60);
    const auto along = [&](int k) {
      return double(
          state.motion.u[std::size_t(node_slot(model.anatomy.lattice, {size.x / 2, size.y / 2, k}))].x);
    };
    const double stiff = (kCells * kSpacing - 0.001) / shear_modulus(kYoung),
                 fascia = 0.001 / (slide * shear_modulus(1e4));
    EXPECT_NEAR(along(kCells) / (traction * (stiff + fascia)), 1, 0.02) << "slide " << slide;
    // the cell of 4 to 8 mm has the fascia: the step in it is the sliding
    const double step_of_cell = along(kCells - 1) - along(kCells - 2);
    EXPECT_NEAR(step_of_cell / (traction * (0.003 / shear_modulus(kYoung) + fascia)), 1, 0.02)
        << "slide " << slide;
    tops.push_back(along(kCells));
  }
  EXPECT_GT(tops[2], 1.5 * tops[0]) << "a fascia with a twentieth of its shear modulus slides";
}

// Depth is the distance from the outermost nodes, also where the surface is oblique.
TEST(CellLaws, DepthsAreDistances) {
  BodyNodes nodes;
  nodes.grid.size = {30, 30, 4};
  nodes.grid.spacing = {0.003, 0.003, 0.003};
  nodes.tissue.assign(sample_count(nodes.grid), Tissue::kMuscle);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 30; j++)
      for (int i = 0; i < 30; i++)
        if (i + j > 40) nodes.tissue[sample_index(nodes.grid, i, j, k)] = Tissue::kOutside;
  const std::vector<float> depth = node_depths(kBoth, nodes);
  for (const int i : {8, 12, 18}) {
    const double distance = (40 - 2 * i) * 0.003 / std::sqrt(2.0);  // from the outermost nodes, i + j = 40
    EXPECT_NEAR(double(depth[sample_index(nodes.grid, i, i, 2)]), distance, 0.4 * 0.003);
  }
}

// Labels, free bone and gas keep their moduli below layers.
TEST(CellLaws, LayersLeaveOtherTissue) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.layers = {{"all", 0, {}, 1234, 0.3, 0}};
  Block block{.size = {6, 5, 5}, .young = params.tissue.muscle};
  BodyNodes nodes = block_nodes(block);
  for (int j = 0; j < 5; j++)
    for (int k = 0; k < 5; k++) nodes.young[sample_index(nodes.grid, 0, j, k)] = 7e3f;  // of a label
  const Model model = assemble(kBoth, nodes, nullptr, params).value();
  const auto young = [&](int i) {
    return model.anatomy.cell_young[std::size_t(node_slot(model.anatomy.lattice, {i, 1, 1}))];
  };
  EXPECT_NEAR(double(young(3)), 1234, 0.1);
  EXPECT_NEAR(double(young(0)), std::sqrt(7e3 * params.tissue.muscle), 1) << "shares nodes with a label";
}

}  // namespace
}  // namespace turgor::lattice
