#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

constexpr double kDisc = 0.006;  // [m]

struct Block {
  sfem::Model model;
  SolidBoundary boundary;
  rhombus::Surface surface;
  std::vector<double> stiffness;

  /// Stiffness factor at the surface vertex nearest to a position.
  double at(Vec3d position) const {
    std::size_t nearest = 0;
    for (std::size_t v = 0; v < surface.vertices.size(); v++)
      if (norm(surface.vertices[v] - position) < norm(surface.vertices[nearest] - position)) nearest = v;
    return stiffness[nearest];
  }
};

Block block(Vec3d size, Int3 count, double young, const std::function<bool(Vec3d)>& is_fixed) {
  sfem::Body body;
  body.mesh = hex_block(size, count);
  body.materials = {{young, 0.45}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(is_fixed(x));
  Block b{*sfem::build(Exec(2), std::move(body), {.formulation = sfem::Formulation::kAveraged}), {}, {}, {}};
  EXPECT_TRUE(sfem::compute_green(Exec(2), b.model, std::size_t(1) << 30));
  b.boundary = solid_boundary(b.model);
  b.surface = *rhombus::build_surface(b.boundary.body.vertices, b.boundary.body.triangles);
  b.stiffness = *elastic_stiffness(Exec(2), b.model, b.boundary, b.surface, kDisc);
  return b;
}

// The middle of a thick block has the stiffness of a half-space for any modulus.
TEST(ElasticStiffness, ThickBlockIsHalfSpace) {
  for (const double young : {1e3, 5e4}) {
    const Block thick = block({0.12, 0.12, 0.06}, {12, 12, 6}, young, [](Vec3d x) { return x.z < 1e-9; });
    EXPECT_NEAR(thick.at({0.06, 0.06, 0.06}), 1, 0.15);
    EXPECT_EQ(thick.at({0.06, 0.06, 0}), 50) << "at the fixed side";
  }
}

// A cantilever plate softens with the distance from its clamp, as Timoshenko's beam does.
TEST(ElasticStiffness, CantileverSoftensWithLength) {
  const Block plate = block({0.12, 0.06, 0.02}, {24, 12, 4}, 4e3, [](Vec3d x) { return x.x < 1e-9; });
  double before = 1;
  for (const double along : {0.03, 0.045, 0.06}) {
    const double softening = plate.at({along, 0.03, 0.02});
    EXPECT_LT(softening, 0.8 * before) << along;
    before = softening;
  }
  // Timoshenko's beam of this section under a force at 60 mm, and a half-space under the disc.
  const double inertia = 0.06 * std::pow(0.02, 3) / 12, area = 0.06 * 0.02, shear = 4e3 / 2.9;
  const double beam = std::pow(0.06, 3) / (3 * 4e3 * inertia) + 0.06 / (5.0 / 6 * shear * area);
  const double touched = 1 / (2 * 4e3 / (1 - 0.45 * 0.45) * kDisc);
  EXPECT_NEAR(before / (touched / (touched + beam)), 1, 0.35);
}

// Only the body that the surface belongs to may supply the stiffness.
TEST(ElasticStiffness, RejectsBodyOfOtherSurface) {
  const std::string two =
      "[body.a]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count = [4, 4, 2] }\n"
      "fixed = \"bottom\"\n[body.b]\nmodel = \"rhombus\"\n";
  const Result<Scene> right =
      parse_scene(two + "surface_of = \"a\"\nstiffness = { body = \"a\" }\n", "s.toml");
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_TRUE(std::holds_alternative<ElasticStiffness>(right->rhombus_bodies[0].stiffness->source));
  const Result<Scene> wrong =
      parse_scene(two + "surface = { phantom = \"liver\" }\nstiffness = { body = \"a\" }\n", "s.toml");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("the body that surface_of names"), std::string::npos);
}

}  // namespace
}  // namespace turgor
