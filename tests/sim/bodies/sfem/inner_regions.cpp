#include "turgor/sim/bodies/sfem/inner_regions.hpp"

#include <cmath>
#include <numbers>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/sim/bodies/sfem/make_body.hpp"

namespace turgor {
namespace {

double volume_inside(const std::vector<Vec3d>& x, const InnerRegion& region) {
  double sum = 0;
  for (const Int3 t : region.triangles) {
    const auto at = [&](int v) { return x[std::size_t(region.vertices[std::size_t(v)])]; };
    sum += dot(at(t.x), cross(at(t.y), at(t.z))) / 6;
  }
  return sum;
}

SfemScene with_a_nodule_and_a_cyst() {
  SfemScene scene;
  scene.inside = {{"nodule", 200, {4e4, 0.4}}};
  scene.inclusions = {{.name = "cyst",
                       .center = {0.07, 0.03, 0.02},
                       .by_fraction = false,
                       .radius = 0.012,
                       .material = {500, 0.3}}};
  return scene;
}

// The surface of an inner region encloses the volume of its elements, for every element type.
TEST(InnerRegions, SurfaceEnclosesElements) {
  SolidMesh block = hex_block({0.1, 0.1, 0.05}, {10, 10, 5});
  for (const SolidMesh& kind : {block, tetrahedralize(block), with_middles(tetrahedralize(block))}) {
    SolidMesh mesh = kind;
    mesh.regions.assign(element_count(mesh), 5);
    double nodule = 0;
    for (std::size_t e = 0; e < element_count(mesh); e++)
      if (norm(centroid(mesh, e) - Vec3d{0.03, 0.06, 0.025}) < 0.015)
        mesh.regions[e] = 200, nodule += volume(mesh, e);
    const SfemScene scene = with_a_nodule_and_a_cyst();
    const sfem::Body body = make_body(mesh, scene).value();
    const std::vector<InnerRegion> regions = inner_regions(scene, body);
    ASSERT_EQ(regions.size(), 2u);
    EXPECT_EQ(regions[0].name, "nodule");
    EXPECT_EQ(regions[1].name, "cyst");
    EXPECT_NEAR(volume_inside(body.mesh.vertices, regions[0]), nodule, 1e-9 * nodule);
    EXPECT_NEAR(4 * std::numbers::pi / 3 * std::pow(regions[0].radius, 3), nodule, 1e-9 * nodule);
    EXPECT_LT(norm(regions[0].center - Vec3d{0.03, 0.06, 0.025}), 0.004);
    EXPECT_LT(norm(regions[1].center - Vec3d{0.07, 0.03, 0.02}), 0.004);
  }
}

// An inner region moves down under a press above it.
TEST(InnerRegions, RegionMovesUnderPress) {
  const auto folder = test::fresh_folder();
  const Exec exec(1);
  const Scene scene = test::body_scene(
      folder, "inclusion.bead = { center = [0.03, 0.03, 0.018], radius = 0.008, young = 5e4 }\n");
  World world = test::sfem_world(exec, scene);
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  const TriMesh before = snapshot.bodies[0].inside;
  ASSERT_FALSE(before.triangles.empty());
  for (int frame = 0; frame < 13; frame++) ASSERT_TRUE(step(exec, world));  // the finger is above the region
  show(exec, world, snapshot);
  const TriMesh& after = snapshot.bodies[0].inside;
  ASSERT_EQ(after.vertices.size(), before.vertices.size());
  double most = 0;
  for (std::size_t v = 0; v < after.vertices.size(); v++)
    most = std::max(most, double(before.vertices[v].z - after.vertices[v].z));
  EXPECT_GT(most, 2e-4);
  EXPECT_LT(most, 3e-3) << "the depth of the press";
  EXPECT_EQ(after.normals.size(), after.vertices.size());
}

}  // namespace
}  // namespace turgor
