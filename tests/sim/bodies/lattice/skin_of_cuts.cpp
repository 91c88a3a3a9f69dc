// Drawn skin at a wound. A triangle lies on one side of the blade, even if the CT's skin lies beyond the
// lattice's tissue and all nodes are on the other side.
#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

/// A torso with one node per voxel, cut across at a height in fractions of its box.
LatticeBody cut_torso(double height, double bow) {
  const auto folder = test::fresh_folder();
  test::write(folder / "scene.toml",
              fmt::format("[world]\nduration = 0.2\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\n"
                          "ct = {{ phantom = \"torso\", size = [96, 80, 60], spacing_mm = [4.2, 4, 4.5] }}\n"
                          "block = 1\nfixed = [\"bone\", \"ends\"]\nsolver = {{ coarse = false }}\n"
                          "[incision.across]\nbody = \"torso\"\n"
                          "path_fraction = [[0.38, 0, {0}], [0.5, 0, {1}], [0.62, 0, {0}]]\n",
                          height, height + bow));
  World world = load_world(Exec(2), read_scene(folder / "scene.toml").value()).value();
  for (int frame = 0; frame < 8; frame++) EXPECT_TRUE(step(Exec(2), world).value().finite);
  return std::move(world.lattice_bodies[0]);
}

void expect_no_bridge(const LatticeBody& body) {
  const lattice::BodySurface surface = build_surface(body.model, body.state.cuts(), &body.ct);
  const auto lip_distance = [&](int a, int b) {
    return norm(Vec3d(vertex_displacement(body.model, *body.state, surface, a) -
                      vertex_displacement(body.model, *body.state, surface, b)));
  };
  double gape = 0, most = 0;
  for (const lattice::Lip& lip : surface.lips) gape = std::max(gape, lip_distance(lip.left, lip.right));
  for (int t = 0; t < surface.skin_triangles; t++) {
    const Int3 v = surface.triangles[std::size_t(t)];
    for (int c = 0; c < 3; c++) most = std::max(most, lip_distance(v[c], v[(c + 1) % 3]));
  }
  EXPECT_GT(gape, 0.008);
  EXPECT_LT(most, 0.55 * gape) << "m, the largest stretch of a triangle's side";
}

// No triangle bridges a wound, even if the CT's skin lies beyond the nodes.
TEST(SkinOfCuts, NoTriangleBridgesWound) {
  for (const double height : {0.45, 0.5}) {
    SCOPED_TRACE(height);
    expect_no_bridge(cut_torso(height, 0));
  }
  expect_no_bridge(cut_torso(0.47, 0.006));
}

}  // namespace
}  // namespace turgor
