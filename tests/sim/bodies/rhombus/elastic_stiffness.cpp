#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

constexpr double kDisc = 0.006;  // [m]

struct Block {
  sfem::Model model;
  SurfacePart part;
  rhombus::Surface surface;
  std::vector<double> stiffness;

  /// At the vertex of the surface nearest to a place.
  double at(Vec3d place) const {
    std::size_t nearest = 0;
    for (std::size_t v = 0; v < surface.vertices.size(); v++)
      if (norm(surface.vertices[v] - place) < norm(surface.vertices[nearest] - place)) nearest = v;
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
  b.part = surface_part(b.model);
  b.surface = *rhombus::build_surface(b.part.body.vertices, b.part.body.triangles);
  b.stiffness = *elastic_stiffness(Exec(2), b.model, b.part, b.surface, kDisc);
  return b;
}

TEST(ElasticStiffness, the_middle_of_a_thick_block_is_like_a_half_space_whatever_its_modulus) {
  for (const double young : {1e3, 5e4}) {
    const Block thick = block({0.12, 0.12, 0.06}, {12, 12, 6}, young, [](Vec3d x) { return x.z < 1e-9; });
    EXPECT_NEAR(thick.at({0.06, 0.06, 0.06}), 1, 0.15);
    EXPECT_EQ(thick.at({0.06, 0.06, 0}), 50) << "where it is held";
  }
}

TEST(ElasticStiffness, a_plate_that_sticks_out_is_the_softer_the_farther_it_does) {
  const Block plate = block({0.12, 0.06, 0.02}, {24, 12, 4}, 4e3, [](Vec3d x) { return x.x < 1e-9; });
  double before = 1;
  for (const double along : {0.03, 0.045, 0.06}) {
    const double here = plate.at({along, 0.03, 0.02});
    EXPECT_LT(here, 0.8 * before) << along;
    before = here;
  }
  // Timoshenko's beam of this section under a force at 60 mm, and a half space under the disc.
  const double inertia = 0.06 * std::pow(0.02, 3) / 12, area = 0.06 * 0.02, shear = 4e3 / 2.9;
  const double beam = std::pow(0.06, 3) / (3 * 4e3 * inertia) + 0.06 / (5.0 / 6 * shear * area);
  const double touched = 1 / (2 * 4e3 / (1 - 0.45 * 0.45) * kDisc);
  EXPECT_NEAR(before / (touched / (touched + beam)), 1, 0.35);
}

TEST(ElasticStiffness, only_the_body_of_the_surface_lends_its_stiffness) {
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
  EXPECT_NE(wrong.error().message.find("the body whose surface_of this is"), std::string::npos);
}

}  // namespace
}  // namespace turgor
