#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);

/// A cylinder along k with a lung, a bone and fat, above a table that it does not touch.
CtVolume body_on_table(Int3 size) {
  CtVolume ct{{.size = size, .spacing = {1e-3, 1e-3, 1e-3}}, {}};
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const double r = std::hypot(i - 31.5, j - 28.5), lung = std::hypot(i - 38, j - 28),
                     bone = std::hypot(i - 24, j - 28);
        std::int16_t hu = kAirHu;
        if (r < 20) hu = r > 17 ? -100 : 50;
        if (lung < 6) hu = -850;
        if (bone < 4) hu = 700;
        if (j >= 56 && j < 61) hu = 100;
        ct.samples.push_back(hu);
      }
  return ct;
}

// Nodes are the corners of the blocks of voxels, as in the paper.
TEST(LatticeBuild, NodesAreBlockCorners) {
  const CtVolume ct{{.size = {512, 512, 300}, .spacing = {1, 1, 1}}, {}};
  CtVolume small = body_on_table({64, 64, 30});
  const BodyNodes nodes = classify(kExec, small, nullptr, {}).value();
  EXPECT_EQ(nodes.grid.size, (Int3{17, 17, 9}));
  EXPECT_NEAR(nodes.grid.spacing.x, 4e-3, 1e-12);
  EXPECT_NEAR(nodes.grid.origin.x, -0.5e-3, 1e-12);
}

// The HU of a node is the mean of the block around it.
TEST(LatticeBuild, NodeHuIsBlockMean) {
  CtVolume ct = body_on_table({64, 64, 32});
  for (std::size_t n = 0; n < ct.samples.size(); n++) ct.samples[n] = std::int16_t(n % 64 * 10);  // 10 i
  const BodyNodes nodes = classify(kExec, ct, nullptr, {}).value();
  for (int i = 1; i < 16; i++)  // node i is at voxel 4 i − 1/2
    EXPECT_EQ(nodes.hu[sample_index(nodes.grid, i, 5, 3)], 40 * i - 5);
}

// Table and air are removed, the lung remains, and bone is fixed.
TEST(LatticeBuild, ClassifiesTissues) {
  Params params;
  params.block = {2, 2, 2};
  const CtVolume ct = body_on_table({64, 64, 30});
  const BodyNodes nodes = classify(kExec, ct, nullptr, params).value();
  const auto tissue = [&](int i, int j) { return nodes.tissue[sample_index(nodes.grid, i / 2, j / 2, 7)]; };
  EXPECT_EQ(tissue(2, 2), Tissue::kOutside);
  EXPECT_EQ(tissue(32, 58), Tissue::kOutside) << "the table";
  EXPECT_EQ(tissue(38, 28), Tissue::kGas) << "the lung";
  EXPECT_EQ(tissue(24, 28), Tissue::kBone);
  EXPECT_EQ(tissue(32, 40), Tissue::kMuscle);
  EXPECT_EQ(tissue(32, 48), Tissue::kFat);
  for (std::size_t n = 0; n < nodes.tissue.size(); n++)
    EXPECT_EQ(nodes.fixed[n] != 0, nodes.tissue[n] == Tissue::kBone);
}

// Labels set the Young's modulus.
TEST(LatticeBuild, LabelsSetStiffness) {
  Params params;
  params.block = {2, 2, 2};
  params.tissue.young_of_label[5] = 3210;
  const CtVolume ct = body_on_table({64, 64, 30});
  LabelVolume labels{ct.grid, std::vector<std::uint16_t>(ct.samples.size(), 0)};
  for (int k = 0; k < 30; k++)
    for (int j = 34; j < 42; j++)
      for (int i = 28; i < 36; i++) labels.at(i, j, k) = 5;
  const BodyNodes nodes = classify(kExec, ct, &labels, params).value();
  EXPECT_EQ(nodes.young[sample_index(nodes.grid, 16, 19, 7)], 3210);
  EXPECT_EQ(nodes.young[sample_index(nodes.grid, 16, 11, 7)], float(params.tissue.muscle));
}

// A CT that contains only air is rejected.
TEST(LatticeBuild, RejectsCtOfAir) {
  const CtVolume air{{.size = {16, 16, 16}, .spacing = {1e-3, 1e-3, 1e-3}},
                     std::vector<std::int16_t>(16 * 16 * 16, kAirHu)};
  const auto model = build(kExec, air, {}, {});
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("contains only air"), std::string::npos);
}

// A CT without air outside the body has no skin and is rejected.
TEST(LatticeBuild, RejectsCtWithoutSkin) {
  const CtVolume full{{.size = {16, 16, 16}, .spacing = {1e-3, 1e-3, 1e-3}},
                      std::vector<std::int16_t>(16 * 16 * 16, 40)};
  const auto model = build(kExec, full, {}, {});
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("no skin"), std::string::npos);
}

// A model and its state need at most 80 bytes per node.
TEST(LatticeBuild, MemoryPerNodeIsBounded) {
  CtVolume ct = body_on_table({64, 64, 64});
  CtVolume large{{.size = {256, 256, 128}, .spacing = {1e-3, 1e-3, 1e-3}}, {}};
  for (int k = 0; k < 128; k++)
    for (int j = 0; j < 256; j++)
      for (int i = 0; i < 256; i++) large.samples.push_back(ct.at(i / 4, j / 4, k / 2));
  Params params;
  params.block = {2, 2, 2};
  const Model model = build(kExec, large, {}, params).value();
  const State state = make_state(model);
  EXPECT_LE(double(memory_bytes(model, state)) / node_count(model.anatomy.lattice), 80.0)
      << "a quarter of it is skin, laid out for vector units";
}

/// The same scan with its axes stored in another order: index p[n] runs along axis order[n].
CtVolume stored_as(const CtVolume& ct, std::array<int, 3> order) {
  CtVolume out{.grid = ct.grid, .samples = std::vector<std::int16_t>(ct.samples.size())};
  for (int n = 0; n < 3; n++) {
    out.grid.size[n] = ct.grid.size[order[std::size_t(n)]];
    out.grid.axes.column[n] = ct.grid.axes.column[order[std::size_t(n)]];
  }
  for (int k = 0; k < out.grid.size.z; k++)
    for (int j = 0; j < out.grid.size.y; j++)
      for (int i = 0; i < out.grid.size.x; i++) {
        Int3 p;
        for (int n = 0; n < 3; n++) p[order[std::size_t(n)]] = Int3{i, j, k}[n];
        out.at(i, j, k) = ct.at(p.x, p.y, p.z);
      }
  return out;
}

// fix_ends fixes the ends at head and feet for any order of the scan's axes.
TEST(LatticeBuild, FixedEndsIgnoreAxisOrder) {
  Params params;
  params.block = {2, 2, 2};
  params.fix_ends = true;
  CtVolume axial = body_on_table({64, 64, 48});
  for (int k = 0; k < 48; k++)  // the table is longer than a hand and only just touches the back
    for (int i = 0; i < 64; i++)
      for (int j = 48; j < 51; j++) axial.at(i, j, k) = 100;
  axial.grid.spacing = {3e-3, 3e-3, 3e-3};
  const BodyNodes expected = classify(kExec, axial, nullptr, params).value();
  long ends = 0, gas = 0;
  for (std::size_t n = 0; n < expected.fixed.size(); n++)
    ends += is_body(expected.tissue[n]) && expected.fixed[n], gas += expected.tissue[n] == Tissue::kGas;
  EXPECT_GT(ends, 100);
  EXPECT_GT(gas, 100) << "a lung that is open at the ends of the scan";
  for (const std::array<int, 3> order : {std::array{0, 2, 1}, {2, 0, 1}, {1, 2, 0}, {1, 0, 2}}) {
    const BodyNodes nodes = classify(kExec, stored_as(axial, order), nullptr, params).value();
    long tissue = 0, fixed = 0;
    for (int k = 0; k < nodes.grid.size.z; k++)
      for (int j = 0; j < nodes.grid.size.y; j++)
        for (int i = 0; i < nodes.grid.size.x; i++) {
          Int3 p;
          for (int n = 0; n < 3; n++) p[order[std::size_t(n)]] = Int3{i, j, k}[n];
          const std::size_t a = sample_index(nodes.grid, i, j, k),
                            b = sample_index(expected.grid, p.x, p.y, p.z);
          tissue += nodes.tissue[a] != expected.tissue[b], fixed += nodes.fixed[a] != expected.fixed[b];
        }
    EXPECT_EQ(tissue, 0) << order[0] << order[1] << order[2];
    EXPECT_EQ(fixed, 0) << order[0] << order[1] << order[2];
  }
}

}  // namespace
}  // namespace turgor::lattice
