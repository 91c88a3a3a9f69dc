#include "turgor/contact/cloth_obstacle.hpp"

#include "tests/models/cloth_sheets.hpp"

namespace turgor::contact {
namespace {

using namespace cloth;

TEST(ClothObstacle, a_sheet_that_falls_on_shapes_stays_outside_of_them) {
  for (const Shape& shape :
       {Shape(Sphere{.radius = 0.05}), Shape(Capsule{.radius = 0.04, .half_length = 0.05})}) {
    Params params;
    params.collision.thickness = 0.0096;
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

TEST(ClothObstacle, a_sphere_that_rises_lifts_the_sheet) {
  Params params;
  params.collision.thickness = 0.0096;
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
