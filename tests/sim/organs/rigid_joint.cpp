// Joints: points of a rigid body that are tied to another body.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "tests/elliptic.hpp"

namespace turgor {
namespace {

std::string joint_world(const std::string& gravity, const std::string& bodies) {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n" + bodies;
}
std::string rigid_part(const std::string& name, const std::string& shape, const std::string& at,
                       const std::string& keys) {
  return "[body." + name + "]\nmodel = \"rigid\"\nshape = " + shape + "\nat = " + at + "\n" + keys;
}

// A rod on a hinge swings about points inside of another rigid body, which stay where they are.
TEST(RigidJoint, InsideOfBody_StaysThere) {
  const Exec exec(2);
  constexpr double kHalf = 0.15, kAmplitude = 40 * std::numbers::pi / 180;
  const Vec3d at{-kHalf * std::sin(kAmplitude), 0, -kHalf * std::cos(kAmplitude)};
  const std::string joint = "at = [[0, -0.005, 0], [0, 0.005, 0]]\nstiffness = 1e6\n",
                    rod = rigid_part("rod", "{ box = [0.02, 0.03, 0.3] }",
                                     fmt::format("[{}, {}, {}]", at.x, at.y, at.z),
                                     "turn = [0, 40, 0]\nmass = 0.4\n");
  // 10 mm below the surface of the other body
  World world = test::organs_world(
      exec, joint_world("[0, 0, -9.81]", rod +
                                             rigid_part("stand", "{ box = [0.08, 0.08, 0.08] }",
                                                        "[0.01, 0, -0.03]", "mass = 1\nfixed = true\n") +
                                             "[attachment.joint]\nbetween = [\"rod\", \"stand\"]\n" + joint));
  const RigidBody& body = world.rigid_bodies[world.rigid_bodies[0].name == "rod" ? 0 : 1];
  const double inertia = 0.4 / 12 * (0.02 * 0.02 + 0.3 * 0.3) + 0.4 * kHalf * kHalf,
               period = 4 * std::sqrt(inertia / (0.4 * 9.81 * kHalf)) *
                        test::elliptic_k(std::pow(std::sin(kAmplitude / 2), 2));
  double farthest = 0, before = body.state.center.x, crossed = 0;
  for (int n = 0; n < 90; n++) {
    test::advance(exec, world, 1);
    const Pose pose = rigid::pose_of(body.model, body.state);
    farthest = std::max(farthest, norm(to_world(pose, {})));
    const double now = body.state.center.x;
    if (crossed == 0 && now * before < 0) crossed = (n + before / (before - now)) * world.dt;
    before = now;
  }
  std::printf("joint moved by %.2e m, vertical after %.4f s, a quarter of the period is %.4f s\n", farthest,
              crossed, period / 4);
  EXPECT_LT(farthest, 1e-4) << "m";
  EXPECT_NEAR(crossed, period / 4, 0.02 * period);
}

// Points are tied to the surface of tissue, which must be near.
TEST(RigidJoint, FarFromTissue_IsRefused) {
  const auto loaded = [](const std::string& distance) {
    const Scene scene = test::organs_scene(
        joint_world("[0, 0, -9.81]",
                    rigid_part("rod", "{ box = [0.02, 0.03, 0.1] }", "[0.03, 0.03, 0.08]", "mass = 0.4\n") +
                        test::block_text("pad", "[0, 0, 0]", "[0.06, 0.06, 0.02]", "[3, 3, 1]", "bottom") +
                        "[attachment.joint]\nbetween = [\"rod\", \"pad\"]\nat = [0.03, "
                        "0.03, 0.027]\nstiffness = 100\n" +
                        distance));
    const Result<World> world = load_world(Exec(1), scene);
    return world ? std::string() : world.error().message;
  };
  EXPECT_NE(loaded("").find("attachment.joint: the point 0.03, 0.03, 0.027 m is 0.007 m away from pad, "
                            "expected at most 0.003 m"),
            std::string::npos)
      << loaded("");
  EXPECT_EQ(loaded("distance = 0.0071\n"), "");
}

}  // namespace
}  // namespace turgor
