// A ball of tissue, meshed from its surface and pressed at a point unrelated to the mesh. The test bounds the
// error of a coarse mesh in depth and force.
#include <cmath>

#include <fmt/format.h>

#include "tests/geometry/shapes.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {
namespace {

constexpr double kRadius = 0.05, kTool = 0.015, kDeep = 0.004;  // [m]

/// One press along the surface normal that is tilted about y [rad].
std::string ball_scene_text(double size, double tilt) {
  const Vec3d outward{std::sin(tilt), 0, std::cos(tilt)};
  const Vec3d from = outward * (kRadius + kTool + 0.0005), to = outward * (kRadius + kTool - kDeep);
  return fmt::format(
      "[world]\nduration = 0.1\n[body.ball]\nmodel = \"sfem\"\nsurface = \"ball.obj\"\nresolution = {}\n"
      "young = 4e3\nfixed = {{ sides = \"bottom\", depth = 0.3 }}\ncache = false\n"
      "[tool.finger]\nbody = \"ball\"\nshape = {{ sphere = {} }}\n"
      "path = [[0, {}, {}, {}], [0.08, {}, {}, {}], [0.1, {}, {}, {}]]\n",
      size, kTool, from.x, from.y, from.z, to.x, to.y, to.z, to.x, to.y, to.z);
}

ForceSample pressed(double size, double tilt) {
  const auto folder = test::fresh_folder();
  const TriMesh ball = test::sphere_surface({}, kRadius, 4);
  std::string obj;
  for (const Vec3 x : ball.vertices) obj += fmt::format("v {} {} {}\n", x.x, x.y, x.z);
  for (const Int3 t : ball.triangles) obj += fmt::format("f {} {} {}\n", t.x + 1, t.y + 1, t.z + 1);
  EXPECT_TRUE(write_file(folder / "ball.obj", obj));
  const Scene scene = parse_scene(ball_scene_text(size, tilt), folder / "ball.toml", {}).value();
  const Exec exec(2);
  World world = test::sfem_world(exec, scene);
  for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(exec, world));
  return world.tools[0].samples.back();
}

// A coarse ball has the tool's depth and the force of a fine mesh.
TEST(CurvedBall, CoarseMeshMatchesFineForce) {
  for (const double tilt : {0.0, 0.6}) {
    const double fine = norm(pressed(0.0135, tilt).force);
    for (const double size : {0.03, 0.02}) {
      const ForceSample coarse = pressed(size, tilt);
      EXPECT_NEAR(coarse.depth, kDeep, 0.04 * kDeep) << size << ", " << tilt;
      EXPECT_NEAR(norm(coarse.force), fine, 0.1 * fine) << size << ", " << tilt;
    }
  }
}

}  // namespace
}  // namespace turgor
