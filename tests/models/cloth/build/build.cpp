#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {
namespace {

std::string error_of(const TriMesh& mesh, const Params& params = {}) {
  const Result<Model> model = build(Exec(1), mesh, params);
  return model ? "no error" : model.error().message;
}

// The mass of a sheet is its area times its density.
TEST(ClothBuild, MassIsAreaTimesDensity) {
  const Model model = must_build(flat_sheet(11, 0.02), {.fabric = {.density = 0.3}});
  EXPECT_NEAR(model.area, 0.04, 1e-8);
  EXPECT_NEAR(model.total_mass, 0.012, 1e-8);
  EXPECT_NEAR(std::accumulate(model.mass.begin(), model.mass.end(), 0.0), 0.012, 1e-7);
  EXPECT_EQ(model.count, 121);
  EXPECT_EQ(model.mass.size(), 128u);
}

/// Two sheets of 20 × 20 cells of 10 mm, the upper one at a distance above the lower one [m].
TriMesh two_layers(double gap) {
  TriMesh mesh = flat_sheet(21, 0.01);
  const TriMesh lower = mesh;
  for (const Vec3 x : lower.vertices) mesh.vertices.push_back(x + Vec3{0.003f, 0.001f, Real(gap)});
  const int first = int(lower.vertices.size());
  for (const Int3 t : lower.triangles) mesh.triangles.push_back({t.x + first, t.y + first, t.z + first});
  return mesh;
}

/// The note about close layers, or an empty string.
std::string layer_note(const TriMesh& mesh, double thickness) {
  for (const std::string& note : must_build(mesh, {.collision = {.thickness = thickness}}).notes)
    if (note.find("another layer") != std::string::npos) return note;
  return "";
}

// Layers closer than the thickness at rest are noted; fine meshes and wider rolls are not.
TEST(ClothBuild, NotesLayersCloserThanThickness) {
  EXPECT_EQ(layer_note(two_layers(0.004), 0.006).substr(0, 13), "882 vertices ");
  EXPECT_EQ(layer_note(two_layers(0.007), 0.006), "");
  EXPECT_EQ(layer_note(flat_sheet(41, 0.0101), 0.01), "") << "neighbors along the sheet";
  TriMesh roll = flat_sheet(61, 0.01);  // rolled up: 0.6 m along a spiral with turns 8 mm apart
  for (Vec3& x : roll.vertices) {
    const double angle = std::sqrt(0.4 + 2 * double(x.x) / (0.008 / (2 * M_PI))),
                 r = 0.008 * angle / (2 * M_PI);
    x = {Real(r * std::cos(angle)), x.y, Real(r * std::sin(angle))};
  }
  EXPECT_EQ(layer_note(roll, 0.006), "");
  EXPECT_NE(layer_note(roll, 0.0095), "");
}

// A sheet that is numbered row by row needs hardly any gathers.
TEST(ClothBuild, RowNumberingNeedsFewGathers) {
  const Model model = must_build(flat_sheet(100), {});
  EXPECT_LT(double(model.rows.gathered.size()) / double(model.rows.stiffness.size()), 0.01);
}

// A shuffled mesh is reordered, so that neighbors have close indices.
TEST(ClothBuild, ReordersShuffledMesh) {
  TriMesh mesh = flat_sheet(40);
  const int count = int(mesh.vertices.size());
  const auto shuffled = [count](int v) { return int((std::int64_t(v) * 977 + 13) % count); };
  TriMesh mixed = mesh;
  for (int v = 0; v < count; v++) mixed.vertices[std::size_t(shuffled(v))] = mesh.vertices[std::size_t(v)];
  for (Int3& t : mixed.triangles) t = {shuffled(t.x), shuffled(t.y), shuffled(t.z)};
  const Model model = must_build(mixed, {});
  int farthest = 0;
  for (const Int3 t : model.triangles)
    farthest = std::max(farthest, std::max({t.x, t.y, t.z}) - std::min({t.x, t.y, t.z}));
  EXPECT_LT(farthest, 3 * 40);
  for (int v = 0; v < count; v++) {
    const int index = model.model_vertex[std::size_t(v)];
    EXPECT_EQ(model.original[std::size_t(index)], v);
    EXPECT_EQ(model.x_rest[std::size_t(index)], mixed.vertices[std::size_t(v)]);
  }
}

/// Force per width and strain of a strip that is stretched by 1 % along x.
double pulled_stiffness(const TriMesh& mesh, const Fabric& fabric, double width) {
  Params params{.fabric = fabric};
  params.collision.self = false;
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  const double rest = energy(model, state, {}).elastic;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    Vec3 x = state.x[v];
    x.x *= 1.01f;
    state.x.set(v, x);
  }
  double length = 0;
  for (const Vec3 x : mesh.vertices) length = std::max(length, double(x.x));
  return 2 * (energy(model, state, {}).elastic - rest) / (0.01 * 0.01) / (length * width);
}

// A square grid of springs has the stiffness of its fabric along warp and weft.
TEST(ClothBuild, SquareGridHasFabricStiffness) {
  const Fabric fabric{.law = Law::kSprings, .warp = 700, .weft = 300, .shear = 0, .bend = 0};
  const TriMesh mesh = flat_sheet(41);
  EXPECT_NEAR(pulled_stiffness(mesh, fabric, 0.4) / 700, 1, 0.03);
  Fabric rotated = fabric;
  rotated.direction = {0, 1, 0};
  EXPECT_NEAR(pulled_stiffness(mesh, rotated, 0.4) / 300, 1, 0.03);
}

// Equilateral triangles of springs have the stiffness of their fabric.
TEST(ClothBuild, EquilateralMeshHasFabricStiffness) {
  // At constant width, a net of springs of 2-D modulus E and Poisson's ratio 1/3 has the stiffness E / (1 −
  // 1/9).
  TriMesh mesh;
  const int n = 60;
  const double s = 0.01;
  for (int j = 0; j <= n; j++)
    for (int i = 0; i <= n; i++)
      mesh.vertices.push_back(Vec3(Vec3d{s * (i + 0.5 * (j % 2)), s * j * std::sqrt(0.75), 0}));
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      const int a = j * (n + 1) + i, b = a + 1, d = a + n + 1, c = d + 1;
      if (j % 2 == 0)
        mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({b, c, d});
      else
        mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
    }
  const Fabric fabric{.law = Law::kSprings, .warp = 500, .weft = 500, .shear = 500, .bend = 0};
  EXPECT_NEAR(pulled_stiffness(mesh, fabric, s * n * std::sqrt(0.75)) / (500 * 9.0 / 8), 1, 0.04);
}

// Bad meshes are rejected; the message names the vertex or triangle.
TEST(ClothBuild, RejectsBadMeshes) {
  EXPECT_EQ(error_of({}), "the mesh has no triangle");
  TriMesh mesh = flat_sheet(4);
  mesh.vertices.push_back({9, 9, 9});
  EXPECT_EQ(
      error_of(mesh),
      "expected every vertex in a triangle, since it has no mass otherwise; found no triangle of vertex 16");
  mesh = flat_sheet(4);
  mesh.triangles.push_back({0, 1, 2});
  EXPECT_EQ(error_of(mesh), "expected triangles with an area, found none in triangle 18");
  mesh.triangles.back() = {0, 1, 99};
  EXPECT_EQ(error_of(mesh), "triangle 18 has vertex 99, expected 0 to 15");
  mesh = flat_sheet(4);
  mesh.vertices[3].y = NAN;
  EXPECT_EQ(error_of(mesh), "expected finite coordinates, found others in vertex 3");
}

// Parameters out of range are rejected with the expected range.
TEST(ClothBuild, RejectsBadParameters) {
  EXPECT_EQ(error_of(flat_sheet(4), {.fabric = {.density = 0}}),
            "density: expected a number above 0 kg/m², found 0");
  EXPECT_EQ(error_of(flat_sheet(4), {.fabric = {.warp = -5}}),
            "warp: expected a number above 0 N/m, found -5");
  EXPECT_EQ(error_of(flat_sheet(4), {.solver = {.sweeps = 0}}), "sweeps: expected 1 or more, found 0");
  EXPECT_EQ(error_of(flat_sheet(4), {.collision = {.thickness = 0.05}}),
            "thickness: expected at most 0.01 m, since half of the mesh's edges are shorter, found 0.05 m");
}

// An edge of three triangles is noted, with the consequence for each law.
TEST(ClothBuild, NotesEdgeOfThreeTriangles) {
  TriMesh mesh = flat_sheet(4);
  mesh.vertices.push_back({0.015f, 0.01f, 0.01f});
  mesh.triangles.push_back({5, 6, 16});
  for (const auto& [law, what] : {std::pair(Law::kSprings, ": each pair of their triangles resists folding"),
                                  std::pair(Law::kSheet, ": these edges do not resist folding")}) {
    const Model model = must_build(mesh, {.fabric = {.law = law}});
    ASSERT_EQ(model.notes.size(), 1u);
    EXPECT_EQ(model.notes[0], std::string("1 edge belongs to more than two triangles (5-6)") + what);
  }
}

/// Two triangles on edge 0-1 with an opening angle, in a plane of arbitrary direction; the second one may be
/// listed in reverse.
TriMesh hinge(double degrees, double size, bool is_reversed) {
  const double a = degrees * std::numbers::pi / 180;
  const Vec3d along = normalized(Vec3d{1, 2, -1}), u = normalized(cross(along, Vec3d{0.3, 1, 0.2})),
              v = cross(along, u);
  const auto at = [&](double x, double y, double turn) {
    return Vec3((along * x + (u * std::cos(turn) + v * std::sin(turn)) * y) * size + Vec3d{0.4, -0.2, 0.1});
  };
  return {.vertices = {at(0, 0, 0), at(1, 0, 0), at(0.3, 1, 0), at(0.6, 0.8, a)},
          .triangles = {{0, 1, 2}, is_reversed ? Int3{0, 1, 3} : Int3{1, 0, 3}}};
}

// Cloth with self-collision notes edges that are folded flat at rest.
TEST(ClothBuild, SelfCollision_NotesFlatFolds) {
  const std::string expected_note =
      "1 edge is folded flat (0-1): the triangles of such an edge touch at rest and may "
      "pass through each other";
  for (const double size : {0.003, 0.05})
    for (const bool is_reversed : {false, true})
      for (const double degrees : {0.0, 0.5, 2.0, 20.0, 90.0, 179.0, 180.0}) {
        const TriMesh mesh = hinge(degrees, size, is_reversed);
        const Collision self_collision{.self = true, .thickness = 0.2 * size};
        const auto& notes = must_build(mesh, {.collision = self_collision}).notes;
        EXPECT_EQ(std::count(notes.begin(), notes.end(), expected_note), degrees < 1)
            << degrees << " degrees";
        EXPECT_TRUE(must_build(mesh, {.collision = {.self = false}}).notes.empty());
      }
}

// Welding joins coincident vertices and closes seams.
TEST(ClothBuild, WeldClosesSeams) {
  TriMesh mesh = flat_sheet(4);
  const TriMesh other =
      make_sheet({.corner = {0.03, 0, 0}, .side = {0.03, 0, 0}, .up = {0, 0.03, 0}, .columns = 3, .rows = 3});
  for (const Int3 t : other.triangles) mesh.triangles.push_back({t.x + 16, t.y + 16, t.z + 16});
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  const Model two = must_build(mesh, {});
  EXPECT_EQ(two.component_begin.size(), 3u);
  const Model one = must_build(mesh, {.weld = 1e-4});
  EXPECT_EQ(one.component_begin.size(), 2u);
  EXPECT_EQ(one.count, 28);
  EXPECT_EQ(one.model_vertex.size(), 32u);
  EXPECT_EQ(one.model_vertex[3], one.model_vertex[16]);
  State state = make_state(one);
  EXPECT_TRUE(hold(one, state, 31));
}

// hold and release reject vertices that do not exist or are not held.
TEST(ClothBuild, HoldRejectsUnknownVertex) {
  const Model model = must_build(flat_sheet(4), {});
  State state = make_state(model);
  EXPECT_EQ(hold(model, state, 16).error().message, "expected a vertex from 0 to 15, found 16");
  EXPECT_EQ(hold(model, state, -1).error().message, "expected a vertex from 0 to 15, found -1");
  EXPECT_EQ(release(model, state, 3).error().message, "vertex 3 is not held");
}

}  // namespace
}  // namespace turgor::cloth
