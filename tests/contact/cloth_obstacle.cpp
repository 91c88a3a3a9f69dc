#include "turgor/contact/cloth_obstacle.hpp"

#include "tests/models/cloth/sheets.hpp"

namespace turgor::contact {
namespace {

using namespace cloth;

// A sheet that falls on a sphere or a capsule stays outside of it.
TEST(ClothObstacle, FallingSheetStaysOutside) {
  for (const Shape& shape :
       {Shape(Sphere{.radius = 0.05}), Shape(Capsule{.radius = 0.04, .half_length = 0.05})}) {
    Params params;
    params.collision.thickness = 0.0096;
    params.fabric.law = Law::kSprings;
    params.solver = {.method = Method::kChebyshev, .sweeps = 16};
    const cloth::Model model = must_build(flat_sheet(25), params);
    cloth::State state = make_state(model);
    const Pose pose{.position = {0.12, 0.11, -0.06}};
    Inputs inputs{.gravity = {0, 0, -9.81}};
    inputs.obstacles.push_back(cloth_obstacle(shape, pose, pose, kFrame));
    double nearest = 1;  // at any time
    for (int frame = 0; frame < 60; frame++) {
      step(Exec(1), model, state, inputs, kFrame);
      for (std::size_t v = 0; v < 625; v++)
        nearest = std::min(nearest, distance(shape, pose, Vec3d(state.x[v])).distance);
    }
    EXPECT_GT(nearest, 0.0018);
    EXPECT_LT(nearest, 0.01);
  }
}

// A ball smaller than a cell does not pass between vertices, slow or fast.
TEST(ClothObstacle, SmallBallDoesNotPassAtAnySpeed) {
  for (const double speed : {0.1, 3.0}) {  // [m/s]
    Params params;
    params.collision.self = false;
    const cloth::Model model = must_build(flat_sheet(11, 0.012), params);
    cloth::State state = make_state(model);
    for (int v = 0; v < 121; v++)
      if (v < 11 || v >= 110) {
        EXPECT_TRUE(hold(model, state, v));
      }
    const Shape shape = Sphere{.radius = 0.004};
    Pose pose{.position = {0.0636, 0.0652, 0.03}};  // above the middle of a triangle
    for (int frame = 0; frame < 60; frame++) {
      Pose next = pose;
      next.position.z = std::max(-0.01, pose.position.z - speed * kFrame);
      Inputs inputs = in_vacuum();
      inputs.obstacles.push_back(cloth_tool(shape, pose, next, kFrame));
      step(Exec(1), model, state, inputs, kFrame);
      pose = next;
    }
    double nearest = 1;
    for (const Int3 t : model.triangles) {
      const Vec3d a(state.x[std::size_t(t.x)]), b(state.x[std::size_t(t.y)]), c(state.x[std::size_t(t.z)]);
      const Vec3d w = closest_weights(pose.position, a, b, c);
      const Vec3d x = a * w.x + b * w.y + c * w.z;
      nearest = std::min(nearest, norm(x - pose.position));
      EXPECT_LT(x.z, pose.position.z + 0.02) << "the sheet stays below or beside the ball";
    }
    double lowest = 0;
    for (std::size_t v = 0; v < 121; v++) lowest = std::min(lowest, double(state.x.z[v]));
    EXPECT_LT(lowest, -0.009) << speed << " m/s: the ball pushes the sheet down";
    EXPECT_GT(nearest, 0.0035) << speed;
  }
}

// A rising sphere lifts the sheet.
TEST(ClothObstacle, RisingSphereLiftsSheet) {
  Params params;
  params.collision.thickness = 0.0096;
  params.fabric.law = Law::kSprings;
  params.solver = {.method = Method::kChebyshev, .sweeps = 16};
  const cloth::Model model = must_build(flat_sheet(25), params);
  cloth::State state = make_state(model);
  const Shape shape = Sphere{.radius = 0.05};
  Pose pose{.position = {0.12, 0.12, -0.053}};
  for (int frame = 0; frame < 60; frame++) {
    Pose next = pose;
    next.position.z += 0.3 * kFrame;
    Inputs inputs{.gravity = {0, 0, -9.81}};
    inputs.obstacles.push_back(cloth_obstacle(shape, pose, next, kFrame));
    step(Exec(1), model, state, inputs, kFrame);
    pose = next;
  }
  double highest = -1;
  for (std::size_t v = 0; v < 625; v++) highest = std::max(highest, double(state.x.z[v]));
  EXPECT_NEAR(highest, pose.position.z + 0.052, 0.004);
}

}  // namespace
}  // namespace turgor::contact
