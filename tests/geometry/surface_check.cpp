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

TEST(SurfaceCheck, a_closed_box_passes_with_its_volume) {
  const auto checked = check_surface(Exec(1), test::box_surface({0.1, 0.2, 0.3}));
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_NEAR(checked->volume, 0.006, 1e-9);
  EXPECT_TRUE(checked->notes.empty());
}

TEST(SurfaceCheck, a_missing_triangle_leaves_three_open_edges_and_they_are_named) {
  TriMesh box = test::box_surface({1, 1, 1});
  const Int3 removed = box.triangles.back();
  box.triangles.pop_back();
  const std::string message = refusal(box);
  EXPECT_NE(message.find("open: 3 edges are of one triangle only"), std::string::npos) << message;
  const int low = std::min(removed.x, removed.y), high = std::max(removed.x, removed.y);
  EXPECT_NE(message.find(std::to_string(low) + "-" + std::to_string(high)), std::string::npos) << message;
}

TEST(SurfaceCheck, a_fin_makes_an_edge_of_three_triangles) {
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

TEST(SurfaceCheck, one_turned_triangle_is_found_at_its_three_edges) {
  TriMesh box = test::box_surface({1, 1, 1});
  std::swap(box.triangles[4].x, box.triangles[4].y);
  EXPECT_NE(refusal(box).find("disagree about what is outside: 3 edges"), std::string::npos) << refusal(box);
}

TEST(SurfaceCheck, a_surface_that_is_inside_out_is_turned_round_with_a_note) {
  TriMesh box = test::box_surface({1, 1, 1});
  for (Int3& t : box.triangles) std::swap(t.x, t.y);
  const auto checked = check_surface(Exec(1), box);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_NEAR(checked->volume, 1, 1e-6);
  ASSERT_EQ(checked->notes.size(), 1u);
  EXPECT_NE(checked->notes[0].find("inside out"), std::string::npos);
}

TEST(SurfaceCheck, triangles_that_share_no_vertices_are_sewn_where_their_corners_meet) {
  const TriMesh box = test::box_surface({1, 1, 1});
  TriMesh soup;
  for (const Int3 t : box.triangles)
    for (int c = 0; c < 3; c++) soup.vertices.push_back(box.vertices[std::size_t(t[c])]);
  for (int i = 0; i < int(box.triangles.size()); i++) soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  EXPECT_EQ(refusal(soup), "accepted");
}

TEST(SurfaceCheck, a_cavity_is_kept_and_a_second_body_is_left_out_with_a_note) {
  TriMesh cavity = test::sphere_surface({0.5, 0.5, 0.5}, 0.2, 2);
  for (Int3& t : cavity.triangles) std::swap(t.x, t.y);
  const TriMesh three =
      joined(joined(test::box_surface({1, 1, 1}), cavity), test::sphere_surface({3, 0, 0}, 0.1, 1));
  const auto checked = check_surface(Exec(1), three);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_EQ(checked->mesh.triangles.size(), 12u + 320);
  EXPECT_LT(checked->volume, 1 - 0.030);
  ASSERT_EQ(checked->notes.size(), 1u);
  EXPECT_NE(checked->notes[0].find("1 smaller part "), std::string::npos) << checked->notes[0];
}

TEST(SurfaceCheck, a_vertex_pushed_through_the_opposite_side_makes_triangles_cross) {
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

TEST(SurfaceCheck, coplanar_neighbors_do_not_cross) {
  EXPECT_TRUE(crossing_triangles(Exec(1), test::surface_of(hex_block({0.1, 0.1, 0.1}, {7, 7, 7}))).empty());
}

/// A frame of a sheet of cloth in free fall, of cells of 10 mm: what was taken for a crossing.
TEST(SurfaceCheck, triangles_a_cell_apart_in_one_plane_but_for_their_last_digits_do_not_cross) {
  const TriMesh two{.vertices = {{0x1.413ddcp-6f, 0x1.44e1a6p-4f, -0x1.12b2cp-3f},
                                 {0x1.e514e6p-6f, 0x1.6dd76cp-4f, -0x1.12b2cp-3f},
                                 {0x1.413dd6p-6f, 0x1.6dd76ap-4f, -0x1.12b2c4p-3f},
                                 {0x1.e514e8p-6f, 0x1.44e1a8p-4f, -0x1.12b2bcp-3f},
                                 {0x1.4475fap-5f, 0x1.44e1a8p-4f, -0x1.12b2b8p-3f},
                                 {0x1.4475fcp-5f, 0x1.6dd76cp-4f, -0x1.12b2bcp-3f}},
                    .triangles = {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_TRUE(crossing_triangles(Exec(1), two).empty());
}

TEST(SurfaceCheck, an_edge_that_passes_exactly_through_an_edge_or_a_corner_crosses) {
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Vec3 place : {Vec3{0.25f, 0, 0}, Vec3{0, 0, 0}, Vec3{0.5f, 0.5f, 0}}) {
    TriMesh two{.vertices = flat, .triangles = {{0, 1, 2}, {3, 4, 5}}};
    for (const Vec3 off : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{-3, -2, 5}})
      two.vertices.push_back(place + off);
    EXPECT_EQ(crossing_triangles(Exec(1), two).size(), 1u) << place.x << ' ' << place.y;
  }
}

TEST(SurfaceCheck, nothing_flat_and_what_is_no_number_are_refused_in_words) {
  EXPECT_EQ(refusal({}), "the surface has no triangles");
  TriMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(refusal(flat), "the surface encloses no volume");
  TriMesh box = test::box_surface({1, 1, 1});
  box.vertices[3].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(refusal(box), "vertex 3 (counted from 0) has a coordinate that is no number");
}

}  // namespace
}  // namespace turgor
