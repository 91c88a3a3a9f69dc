#include "turgor/geometry/phantom_liver.hpp"

#include <gtest/gtest.h>

#include "shapes.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor {
namespace {

/// Count of edges if every edge has two triangles with opposite orientations, else -1.
int closed_edges(const TriMesh& mesh) {
  int count = 0;
  bool closed = true;
  for_each_edge(sorted_edges(mesh.triangles), [&](std::span<const EdgeUse> uses) {
    count++;
    closed = closed && uses.size() == 2 && uses[0].forward != uses[1].forward;
  });
  return closed ? count : -1;
}

// The liver has the paper's counts of vertices and triangles, and the volume of a human liver.
TEST(PhantomLiver, HasPaperCountsAndLiverVolume) {
  const TriMesh liver = phantom_liver();
  EXPECT_EQ(liver.vertices.size(), 3116u);
  EXPECT_EQ(liver.triangles.size(), 6228u);
  const int edges = closed_edges(liver);
  EXPECT_EQ(3116 - edges + 6228, 2) << "closed, without handles";
  EXPECT_GT(test::enclosed_volume(liver), 0.9e-3);  // 0.9 to 1.9 liters
  EXPECT_LT(test::enclosed_volume(liver), 1.9e-3);
}

// A larger detail refines the surface and keeps its volume within 2 %.
TEST(PhantomLiver, DetailRefinesAndKeepsVolume) {
  const TriMesh coarse = phantom_liver(), fine = phantom_liver(5.67);
  EXPECT_NEAR(double(fine.vertices.size()), 100000, 2000);
  EXPECT_GE(closed_edges(fine), 0);
  EXPECT_NEAR(test::enclosed_volume(fine) / test::enclosed_volume(coarse), 1, 0.02);
}

// The forceps' two halves have the paper's counts and meet between the jaws.
TEST(PhantomLiver, ForcepsHavePaperCounts) {
  const TriMesh half = phantom_forceps_half(false), both = phantom_forceps();
  EXPECT_EQ(both.vertices.size(), 174u);
  EXPECT_EQ(both.triangles.size(), 348u);
  EXPECT_EQ(int(half.vertices.size()) - closed_edges(half) + int(half.triangles.size()), 0)
      << "one ring each";
  EXPECT_GT(test::enclosed_volume(half), 0);
  float inner = 1, tip = 1;
  for (const Vec3 x : half.vertices) inner = std::min(inner, x.x), tip = std::min(tip, x.z);
  EXPECT_NEAR(inner, 5e-5, 1e-7) << "the jaw's inner side is next to the plane between the halves";
  EXPECT_NEAR(tip, 0, 1e-7);
  EXPECT_NEAR(test::enclosed_volume(both), 2 * test::enclosed_volume(half), 1e-9);
}

}  // namespace
}  // namespace turgor
