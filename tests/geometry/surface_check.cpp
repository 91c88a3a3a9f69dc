#include "turgor/geometry/surface_check.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"

namespace turgor {
namespace {

std::string refusal(const TriMesh& surface) {
  const auto checked = check_surface(Exec(2), surface);
  return checked ? "accepted" : checked.error().message;
}

TriMesh joined(TriMesh a, const TriMesh& b) {
  const int n = int(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Int3 t : b.triangles) a.triangles.push_back({t.x + n, t.y + n, t.z + n});
  return a;
}

// A closed box passes without notes and has its volume.
TEST(SurfaceCheck, ClosedBoxPasses) {
  const auto checked = check_surface(Exec(1), test::box_surface({0.1, 0.2, 0.3}));
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_NEAR(checked->volume, 0.006, 1e-9);
  EXPECT_TRUE(checked->notes.empty());
}

// The error for a missing triangle names the three open edges.
TEST(SurfaceCheck, MissingTriangle_NamesOpenEdges) {
  TriMesh box = test::box_surface({1, 1, 1});
  const Int3 removed = box.triangles.back();
  box.triangles.pop_back();
  const std::string message = refusal(box);
  EXPECT_NE(message.find("open: 3 edges are of one triangle only"), std::string::npos) << message;
  const int low = std::min(removed.x, removed.y), high = std::max(removed.x, removed.y);
  EXPECT_NE(message.find(std::to_string(low) + "-" + std::to_string(high)), std::string::npos) << message;
}

// A fin makes the surface not a manifold.
TEST(SurfaceCheck, FinIsNotManifold) {
  TriMesh box = test::box_surface({1, 1, 1});
  TriMesh fin = box;
  fin.vertices.push_back({2, 2, 2});
  // A closed pocket without volume on one edge of the box: its edge has four triangles.
  const Int3 t = box.triangles[0];
  fin.triangles.push_back({t.x, t.y, 8});
  fin.triangles.push_back({t.y, t.x, 8});
  EXPECT_NE(refusal(fin).find("not a manifold: 1 edge is of more than two triangles"), std::string::npos)
      << refusal(fin);
}

// A triangle with reversed orientation is reported by its three edges.
TEST(SurfaceCheck, ReversedTriangle_CountsThreeEdges) {
  TriMesh box = test::box_surface({1, 1, 1});
  std::swap(box.triangles[4].x, box.triangles[4].y);
  EXPECT_NE(refusal(box).find("have opposite orientations: 3 edges"), std::string::npos) << refusal(box);
}

// A surface that is inside out is reversed and noted.
TEST(SurfaceCheck, InsideOutIsReversedWithNote) {
  TriMesh box = test::box_surface({1, 1, 1});
  for (Int3& t : box.triangles) std::swap(t.x, t.y);
  const auto checked = check_surface(Exec(1), box);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_NEAR(checked->volume, 1, 1e-6);
  ASSERT_EQ(checked->notes.size(), 1u);
  EXPECT_NE(checked->notes[0].find("inside out"), std::string::npos);
}

// A triangle soup is welded at coincident corners.
TEST(SurfaceCheck, TriangleSoupIsWelded) {
  const TriMesh box = test::box_surface({1, 1, 1});
  TriMesh soup;
  for (const Int3 t : box.triangles)
    for (int c = 0; c < 3; c++) soup.vertices.push_back(box.vertices[std::size_t(t[c])]);
  for (int i = 0; i < int(box.triangles.size()); i++) soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  EXPECT_EQ(refusal(soup), "accepted");
}

// A cavity is kept; a second body is dropped and noted.
TEST(SurfaceCheck, KeepsCavityDropsSecondBody) {
  TriMesh cavity = test::sphere_surface({0.5, 0.5, 0.5}, 0.2, 2);
  for (Int3& t : cavity.triangles) std::swap(t.x, t.y);
  const TriMesh three =
      joined(joined(test::box_surface({1, 1, 1}), cavity), test::sphere_surface({3, 0, 0}, 0.1, 1));
  const auto checked = check_surface(Exec(1), three);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_EQ(checked->mesh.triangles.size(), 12u + 320);
  EXPECT_LT(checked->volume, 1 - 0.030);
  ASSERT_EQ(checked->notes.size(), 1u);
  EXPECT_NE(checked->notes[0].find("1 smaller component "), std::string::npos) << checked->notes[0];
}

// Overlap notes name crossing and nested bodies; separate bodies and cavities have none.
TEST(SurfaceCheck, OverlapNotesNameCrossingAndNestedBodies) {
  const TriMesh box = test::box_surface({1, 1, 1});
  const TriMesh ball = test::sphere_surface({0.5, 0.5, 0.5}, 0.2, 2);
  TriMesh cavity = ball;
  for (Int3& t : cavity.triangles) std::swap(t.x, t.y);
  const auto notes = [](const TriMesh& mesh) { return overlap_notes(Exec(2), mesh); };
  EXPECT_TRUE(notes(box).empty());
  EXPECT_TRUE(notes(joined(box, cavity)).empty());
  EXPECT_TRUE(notes(joined(box, test::sphere_surface({3, 0, 0}, 0.1, 1))).empty());
  const auto nested = notes(joined(box, ball));
  ASSERT_EQ(nested.size(), 1u);
  EXPECT_NE(nested[0].find("1 component of the surface with "), std::string::npos) << nested[0];
  EXPECT_NE(nested[0].find("lies inside another one"), std::string::npos) << nested[0];
  const auto crossing = notes(joined(box, test::sphere_surface({1, 0.45, 0.55}, 0.2, 2)));
  ASSERT_GE(crossing.size(), 1u);
  EXPECT_EQ(crossing[0].find("the surface crosses itself: "), 0u) << crossing[0];
}

// A vertex pushed through the opposite side makes triangles cross.
TEST(SurfaceCheck, DetectsSelfIntersection) {
  TriMesh ball = test::sphere_surface({}, 1, 2);
  EXPECT_TRUE(crossing_triangles(Exec(2), ball).empty());
  ball.vertices[0] = ball.vertices[0] * -1.3f;
  // The five triangles at a vertex of the icosahedron now pass through the other side.
  EXPECT_GE(crossing_triangles(Exec(2), ball).size(), 5u);
  const auto checked = check_surface(Exec(1), ball);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_EQ(checked->crossings, crossing_triangles(Exec(1), ball).size());
  EXPECT_NE(checked->notes.at(0).find("crosses itself"), std::string::npos);
  EXPECT_EQ(crossing_triangles(Exec(1), ball), crossing_triangles(Exec(4), ball));
}

// Coplanar neighbors do not count as crossing.
TEST(SurfaceCheck, CoplanarNeighborsDoNotCross) {
  EXPECT_TRUE(crossing_triangles(Exec(1), test::surface_of(hex_block({0.1, 0.1, 0.1}, {7, 7, 7}))).empty());
}

// Triangles one cell apart that are coplanar except for rounding do not cross. From a frame of a sheet of
// cloth in free fall with cells of 10 mm, which an earlier check took for a crossing.
TEST(SurfaceCheck, NearlyCoplanarTrianglesDoNotCross) {
  const TriMesh two{.vertices = {{0x1.413ddcp-6f, 0x1.44e1a6p-4f, -0x1.12b2cp-3f},
                                 {0x1.e514e6p-6f, 0x1.6dd76cp-4f, -0x1.12b2cp-3f},
                                 {0x1.413dd6p-6f, 0x1.6dd76ap-4f, -0x1.12b2c4p-3f},
                                 {0x1.e514e8p-6f, 0x1.44e1a8p-4f, -0x1.12b2bcp-3f},
                                 {0x1.4475fap-5f, 0x1.44e1a8p-4f, -0x1.12b2b8p-3f},
                                 {0x1.4475fcp-5f, 0x1.6dd76cp-4f, -0x1.12b2bcp-3f}},
                    .triangles = {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_TRUE(crossing_triangles(Exec(1), two).empty());
}

// An edge that passes exactly through another edge or a corner counts as crossing.
TEST(SurfaceCheck, EdgeThroughEdgeOrCornerCrosses) {
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Vec3 point : {Vec3{0.25f, 0, 0}, Vec3{0, 0, 0}, Vec3{0.5f, 0.5f, 0}}) {
    TriMesh two{.vertices = flat, .triangles = {{0, 1, 2}, {3, 4, 5}}};
    for (const Vec3 offset : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{-3, -2, 5}})
      two.vertices.push_back(point + offset);
    EXPECT_EQ(crossing_triangles(Exec(1), two).size(), 1u) << point.x << ' ' << point.y;
  }
}

// Empty and flat surfaces and NaN coordinates are rejected with a message.
TEST(SurfaceCheck, RejectsEmptyFlatAndNan) {
  EXPECT_EQ(refusal({}), "the surface has no triangles");
  TriMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(refusal(flat), "the surface encloses no volume");
  TriMesh box = test::box_surface({1, 1, 1});
  box.vertices[3].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(refusal(box), "vertex 3 (counted from 0) has a coordinate that is not a number");
}

}  // namespace
}  // namespace turgor
