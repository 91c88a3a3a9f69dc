// A blade stops above bone, or cuts through it if that is asked for.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr double kStep = 0.002, kDepth = 0.02;  // [m]
constexpr Int3 kSize{31, 21, 17};
constexpr int kTop = 16;  // highest layer of body nodes

/// Height of a bone surface that slopes along x [m].
double bone_height(double x) { return 0.006 + 0.25 * x; }

/// A block under skin whose bone has a sloping surface.
Model block_on_bone() {
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  Model model =
      block_model({.size = kSize, .spacing = kStep, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++)
        if (Tissue& tissue = model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, i, j, k))];
            is_body(tissue) && k * kStep <= bone_height(i * kStep))
          tissue = Tissue::kBone;
  return model;
}

BladePath blade(const Model& model, double tilt, bool through_bone) {
  const double z = kTop * kStep;
  const Incision incision{.name = "cut",
                          .from = {0.011, 0.0195, z},
                          .to = {0.047, 0.0205, z},
                          .depth = kDepth,
                          .tilt = tilt,
                          .through_bone = through_bone};
  Result<BladePath> path = lay_blade(model, make_state(model), incision);
  EXPECT_TRUE(path) << path.error().message;
  return *path;
}

// The depths follow the surface of the bone within the half cell that a bone node stands for.
TEST(LatticeBoneStop, DepthsFollowBone) {
  const Model model = block_on_bone();
  const BladePath path = blade(model, 0, false);
  for (std::size_t n = 0; n < path.points.size(); n++) {
    const double expected = std::min(kDepth, path.points[n].z - bone_height(path.points[n].x));
    EXPECT_NEAR(path.depths[n], expected, 0.75 * kStep) << "at x = " << path.points[n].x;
  }
  EXPECT_LT(path.depths.back(), kDepth - kStep) << "the blade meets bone";
}

// No edge between two bone nodes is cut, upright or tilted; a blade that may cut bone cuts such edges.
TEST(LatticeBoneStop, CutsNoBoneUnlessAsked) {
  const Model model = block_on_bone();
  const auto bone_edges = [&](const BladePath& path) {
    int count = 0;
    for (const PendingEdgeCut& edge : path.edges) {
      const Int3 a = slot_node(model.anatomy.lattice, edge.slot), b = a + kFamilies[edge.family];
      count += model.anatomy.tissue[std::size_t(edge.slot)] == Tissue::kBone &&
               model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, b))] == Tissue::kBone;
    }
    return count;
  };
  for (const double tilt : {0.0, 25.0}) {
    const BladePath stops = blade(model, tilt, false), cuts = blade(model, tilt, true);
    EXPECT_EQ(bone_edges(stops), 0) << tilt;
    EXPECT_GT(bone_edges(cuts), 20) << tilt;
    EXPECT_GT(stops.edges.size(), 100u) << "soft tissue above bone is cut";
    EXPECT_EQ(cuts.depths, std::vector<double>(cuts.points.size(), kDepth));
  }
}

}  // namespace
}  // namespace turgor::lattice
