#include "turgor/sim/bodies/sfem/make_body.hpp"

#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

SolidMesh block() { return hex_block({0.1, 0.1, 0.05}, {10, 10, 5}); }

int held_count(const HeldBy& held) {
  const std::vector<std::uint8_t> fixed = held_points(block().vertices, held);
  return std::accumulate(fixed.begin(), fixed.end(), 0);
}

// A side fixes the nodes within the given fraction of the box.
TEST(MakeBody, SidesFixRequestedDepth) {
  EXPECT_EQ(held_count({.sides = {Side::kFeet}, .depth = 0}), 11 * 11);
  EXPECT_EQ(held_count({.sides = {Side::kBack}, .depth = 0.1}), 2 * 11 * 6);
  EXPECT_EQ(held_count({.sides = {Side::kLeft, Side::kRight}, .depth = 0}), 2 * 11 * 6);
}

// A box fixes the nodes in it, in meters or in fractions.
TEST(MakeBody, BoxFixesContainedNodes) {
  HeldBy held;
  held.box = {{{-1, -1, -1}, {0.0251, 1, 1}}};
  EXPECT_EQ(held_count(held), 3 * 11 * 6);
  held.box = {{{0, 0, 0}, {1, 0.001, 1}}};
  held.by_fraction = true;
  EXPECT_EQ(held_count(held), 11 * 6);
}

// A depth of whole layers fixes exactly these, on every side, however the coordinates are rounded.
TEST(MakeBody, OppositeSidesFixEqualLayers) {
  constexpr std::array<Side, 6> kSides{Side::kRight, Side::kLeft, Side::kFront,
                                       Side::kBack,  Side::kFeet, Side::kHead};
  for (const Vec3d corner : {Vec3d{}, Vec3d{-0.05, 0.0123, 1.7}, Vec3d{0.31, -0.2, -0.004}})
    for (const double spacing : {0.01, 0.0033, 0.0007})
      for (int layers = 2; layers <= 11; layers++) {
        std::vector<Vec3d> points;
        for (int n = 0; n <= layers; n++)
          for (int side = 0; side < 9; side++) {
            const double t = n * spacing;
            const double u = (side % 3) * layers * spacing / 2, v = (side / 3) * layers * spacing / 2;
            for (const Vec3d x : {Vec3d{t, u, v}, Vec3d{u, t, v}, Vec3d{u, v, t}})
              points.push_back(corner + x);
          }
        for (const Side side : kSides)
          for (int held = 1; held < layers; held++) {
            const double depth = double(held) / layers;
            // the layers, and points of the other two axes at the side, the middle and the opposite side
            const int axis = int(side) / 2;
            const bool is_high = int(side) % 2 == 1;
            int expected = 0;
            for (std::size_t p = 0; p < points.size(); p++) {
              const double from = (points[p] - corner)[axis] / spacing;
              expected += std::lround(2 * (is_high ? layers - from : from)) <= 2 * held;
            }
            const std::vector<std::uint8_t> fixed = held_points(points, {.sides = {side}, .depth = depth});
            EXPECT_EQ(std::accumulate(fixed.begin(), fixed.end(), 0), expected)
                << "side " << int(side) << ", " << held << " of " << layers << " layers of " << spacing;
          }
      }
}

// Labels and spheres become materials of the body.
TEST(MakeBody, LabelsAndSpheresBecomeMaterials) {
  SolidMesh mesh = block();
  mesh.regions.assign(element_count(mesh), 5);
  mesh.regions[7] = 200;
  SfemScene scene;
  scene.inside = {{"nodule", 200, {4e4, 0.4}}};
  scene.inclusions = {{.name = "cyst",
                       .center = {0.5, 0.5, 0.5},
                       .by_fraction = true,
                       .radius = 0.01,
                       .material = {500, 0.3}}};
  const Result<sfem::Body> body = make_body(mesh, scene);
  ASSERT_TRUE(body) << body.error().message;
  ASSERT_EQ(body->materials.size(), 3u);
  EXPECT_EQ(std::accumulate(body->material.begin(), body->material.end(), 0), 1);
  EXPECT_EQ(body->material[7], 1);
  EXPECT_EQ(body->inclusions[0].material, 2);
  EXPECT_NEAR(norm(body->inclusions[0].center - Vec3d{0.05, 0.05, 0.025}), 0, 1e-12);
}

// Materials without elements are errors.
TEST(MakeBody, RejectsMaterialsWithoutElements) {
  SolidMesh mesh = block();
  mesh.regions.assign(element_count(mesh), 5);
  SfemScene scene;
  scene.source_location = "s.toml:3:1: body.b";
  scene.inside = {{"nodule", 200, {4e4, 0.4}}};
  EXPECT_EQ(make_body(mesh, scene).error().message,
            "s.toml:3:1: body.b.inside.nodule: no element has the label 200; known labels: 5");
  scene.inside.clear();
  scene.inclusions = {
      {.name = "far", .center = {1, 1, 1}, .by_fraction = false, .radius = 0.01, .material = {1, 0.3}}};
  EXPECT_NE(make_body(mesh, scene).error().message.find("body.b.inclusion.far: no element has its center in"),
            std::string::npos);
}

// The error for an inclusion outside of the body has the bounds of the body.
TEST(MakeBody, OutsideInclusionNamesBodyBounds) {
  SfemScene scene;
  scene.source_location = "s.toml:3:1: body.b";
  scene.inclusions = {{.name = "far",
                       .center = {0.05, 0.05, 0.35},
                       .by_fraction = false,
                       .radius = 0.01,
                       .material = {1, 0.3}}};
  const Result<sfem::Body> body = make_body(block(), scene);
  ASSERT_FALSE(body);
  EXPECT_NE(body.error().message.find("; the body is between (0, 0, 0) m and (0.1, 0.1, 0.05) m; its nearest "
                                      "point, (0.05, 0.05, 0.05) m, is 0.3 m away"),
            std::string::npos)
      << body.error().message;
}

// The error for an empty box of fixed nodes has the bounds of the body.
TEST(MakeBody, EmptyFixedBoxNamesBodyBounds) {
  SfemScene scene;
  scene.source_location = "s.toml:3:1: body.b";
  scene.fixed.box = {{{0, 0, 0.2}, {0.1, 0.1, 0.3}}};
  const Result<sfem::Body> body = make_body(block(), scene);
  ASSERT_FALSE(body);
  EXPECT_EQ(
      body.error().message,
      "s.toml:3:1: body.b: fixed: the box from (0, 0, 0.2) m to (0.1, 0.1, 0.3) m contains no vertex of "
      "the body; the body is between (0, 0, 0) m and (0.1, 0.1, 0.05) m; its nearest point, (0.05, 0.05, "
      "0.05) "
      "m, is 0.2 m away");
  scene.fixed = {.sides = {Side::kFeet}, .depth = 0};
  EXPECT_TRUE(make_body(block(), scene));
}

// Quadratic elements add mid-edge nodes to tetrahedra and leave hexahedra unchanged.
TEST(MakeBody, QuadraticAddsMidNodesToTetrahedra) {
  SfemScene scene;
  scene.elements = Elements::kQuadratic;
  EXPECT_EQ(make_body(block(), scene)->mesh.corners, 8);
  const SolidMesh tets = tetrahedralize(block());
  EXPECT_EQ(make_body(tets, scene)->mesh.corners, 10);
  scene.elements = Elements::kLinear;
  EXPECT_EQ(make_body(tets, scene)->mesh.corners, 4);
}

}  // namespace
}  // namespace turgor
