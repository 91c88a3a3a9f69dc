#include "turgor/models/cloth/forces/vertex_springs.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// K is −dF/dx, by central differences, with and without slack.
TEST(VertexSprings, StiffnessIsDerivativeOfForce) {
  for (const Real slack : {Real(0), Real(0.2)}) {
    const cloth::VertexSpring spring{
        .vertex = 0, .target = {Real(0.1), 0, Real(-0.2)}, .stiffness = 3, .slack = slack};
    const Vec3 x{Real(0.4), Real(-0.5), Real(0.3)};
    const cloth::VertexSpringForce at = cloth::spring_force(spring, x);
    constexpr Real kStep = Real(1e-2);
    for (int axis = 0; axis < 3; axis++) {
      Vec3 d;
      d[axis] = kStep;
      const Vec3 difference =
          (cloth::spring_force(spring, x - d).force - cloth::spring_force(spring, x + d).force) / (2 * kStep);
      d[axis] = 1;
      EXPECT_LT(norm(difference - at.stiffness_times(d)), 2e-3);
    }
  }
}

// A spring within its slack has neither force nor stiffness.
TEST(VertexSprings, SlackSpringIsLoose) {
  const cloth::VertexSpring spring{.vertex = 0, .target = {}, .stiffness = 3, .slack = Real(0.2)};
  const cloth::VertexSpringForce at = cloth::spring_force(spring, {Real(0.1), 0, 0});
  EXPECT_EQ(at.force, Vec3{});
  EXPECT_EQ(at.stiffness_times({1, 1, 1}), Vec3{});
}

}  // namespace
}  // namespace turgor
