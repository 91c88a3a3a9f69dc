// Layers of tissue on the walls of a wound, against the layers of a block.
#include "turgor/sim/bodies/lattice/wall_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"

namespace turgor {
namespace {

constexpr double kFront = -0.02;  // of the block [m]

/// The wound of the block, 12 mm deep, with these layers. `labeled`: label 3 covers half of it.
BodySnapshot cut_block(const std::string& layers, bool labeled = false) {
  std::vector<std::string> overrides{"body.block.layers=" + layers, "body.block.tissue.partial_cells=false"};
  const std::filesystem::path folder = test::fresh_folder();
  if (labeled) {
    test::write_labeled_block(folder, [](int, int, int k) { return k < 20 ? 3 : 0; });
    overrides.push_back("body.block.labels=" + (folder / "labels.nii").string());
  }
  World world = test::block_world(Exec(2), test::block_scene(folder, overrides));
  for (int frame = 0; frame < 8; frame++) EXPECT_TRUE(step(Exec(2), world));
  WorldSnapshot snapshot;
  show(Exec(2), world, snapshot);
  return std::move(snapshot.bodies[0]);
}

Vec3d rest_of(const BodySnapshot& body, std::size_t v) {
  Vec3d x;
  for (int corner = 0; corner < 3; corner++)
    x += Vec3d(body.rest[std::size_t(body.wall_layers.corner[v][corner])]) *
         double(body.wall_layers.weight[v][corner]);
  return x;
}

/// Area of triangles at rest [m²].
double area_of(Vec3d a, Vec3d b, Vec3d c) { return norm(cross(b - a, c - a)) / 2; }

// Vertices of the walls have the layer of their depth below the flat front of the block, the subdivided walls
// have the area of the walls, and each layer its share of it.
TEST(WallLayers, AreThoseOfTheirDepth) {
  const BodySnapshot body = cut_block(
      "[{ name = \"skin\", thickness = 0.002, young = 1e5, color = [230, 180, 150] }, { name = \"fat\", "
      "thickness = 0.005, young = 4e3, color = [240, 214, 120] }, { name = \"muscle\", young = 2e4 }]");
  const WallLayers& walls = body.wall_layers;
  ASSERT_FALSE(walls.triangles.empty());
  ASSERT_EQ(walls.looks.size(), 3u);
  EXPECT_EQ(walls.looks[1].name, "fat");
  EXPECT_EQ(walls.looks[1].color, (Rgb{240, 214, 120}));
  EXPECT_FALSE(walls.looks[2].color);
  // the drawn front is half a voxel off the voxels' centers
  double front = 1;
  for (std::size_t v = 0; v < walls.corner.size(); v++) front = std::min(front, rest_of(body, v).y);
  EXPECT_NEAR(front, kFront, 0.002);
  for (std::size_t v = 0; v < walls.corner.size(); v++) {
    const double depth = rest_of(body, v).y - front;
    if (std::min(std::abs(depth - 0.002), std::abs(depth - 0.007)) < 1e-4) continue;
    EXPECT_EQ(int(walls.layer[v]), depth < 0.002 ? 0 : depth < 0.007 ? 1 : 2) << depth;
  }
  // areas
  double whole = 0, all = 0;
  std::array<double, 3> shares{};
  for (const Int3 t : std::span(body.triangles).subspan(body.wall_begin))
    whole += area_of(Vec3d(body.rest[std::size_t(t.x)]), Vec3d(body.rest[std::size_t(t.y)]),
                     Vec3d(body.rest[std::size_t(t.z)]));
  for (const Int3 t : walls.triangles) {
    const double area = area_of(rest_of(body, std::size_t(t.x)), rest_of(body, std::size_t(t.y)),
                                rest_of(body, std::size_t(t.z)));
    all += area;
    for (int corner = 0; corner < 3; corner++) shares[walls.layer[std::size_t(t[corner])]] += area / 3;
  }
  EXPECT_NEAR(all, whole, 1e-6 * whole);
  EXPECT_NEAR(shares[0] / shares[1], 2.0 / 5, 0.06);
}

// A region comes before layers by depth: the half of the block that its label covers.
TEST(WallLayers, RegionsComeFirst) {
  const BodySnapshot body = cut_block(
      "[{ name = \"fat\", young = 4e3 }, { name = \"scar\", label = 3, young = 2e4, color = [200, 90, 90] }]",
      true);
  const WallLayers& walls = body.wall_layers;
  ASSERT_FALSE(walls.triangles.empty());
  std::array<int, 2> found{};
  for (std::size_t v = 0; v < walls.corner.size(); v++) {
    const double border = -0.078 + 19.5 * 0.004, z = rest_of(body, v).z;
    if (std::abs(z - border) < 1e-6) continue;
    EXPECT_EQ(int(walls.layer[v]), z < border ? 1 : 0) << z;
    found[walls.layer[v]]++;
  }
  EXPECT_GT(std::min(found[0], found[1]), 100);
}

// Without colors there are no layers on the walls.
TEST(WallLayers, AreOffWithoutColors) {
  const BodySnapshot body = cut_block("[{ name = \"fat\", young = 4e3 }]");
  EXPECT_LT(body.wall_begin, body.triangles.size());
  EXPECT_TRUE(body.wall_layers.triangles.empty());
}

}  // namespace
}  // namespace turgor
