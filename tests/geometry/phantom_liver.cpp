#include "turgor/geometry/phantom_liver.hpp"

#include <gtest/gtest.h>

#include "shapes.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor {
namespace {

/// Edges with two triangles that run opposite ways; -1 when any other edge is found.
int closed_edges(const TriMesh& mesh) {
  int count = 0;
  bool closed = true;
  for_each_edge(sorted_edges(mesh.triangles), [&](std::span<const EdgeUse> uses) {
    count++;
    closed = closed && uses.size() == 2 && uses[0].forward != uses[1].forward;
  });
  return closed ? count : -1;
}

TEST(PhantomLiver, it_has_the_paper_s_numbers_and_the_volume_of_a_liver) {
  const TriMesh liver = phantom_liver();
  EXPECT_EQ(liver.vertices.size(), 3116u);
  EXPECT_EQ(liver.triangles.size(), 6228u);
  const int edges = closed_edges(liver);
  EXPECT_EQ(3116 - edges + 6228, 2) << "closed, without handles";
  EXPECT_GT(test::enclosed_volume(liver), 0.9e-3);  // 0.9 to 1.9 litres
  EXPECT_LT(test::enclosed_volume(liver), 1.9e-3);
}

TEST(PhantomLiver, detail_makes_it_finer_and_keeps_its_shape) {
  const TriMesh coarse = phantom_liver(), fine = phantom_liver(5.67);
  EXPECT_NEAR(double(fine.vertices.size()), 100000, 2000);
  EXPECT_GE(closed_edges(fine), 0);
  EXPECT_NEAR(test::enclosed_volume(fine) / test::enclosed_volume(coarse), 1, 0.02);
}

TEST(PhantomForceps, two_halves_with_the_paper_s_numbers_that_meet_between_the_jaws) {
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
