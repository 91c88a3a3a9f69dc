#include "turgor/contact/forceps.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/geometry/phantom_liver.hpp"

namespace turgor::contact {
namespace {

Forceps phantom(double opening = 0.012) {
  return *build_forceps(phantom_forceps_half(false), phantom_forceps_half(true), opening);
}

/// Distance between the tips along x.
double tip_gap(const TriMesh& mesh) {
  double right = 1, left = -1;
  for (const Vec3 x : mesh.vertices) {
    if (x.z > 0.003) continue;
    if (x.x > 0) right = std::min(right, double(x.x));
    if (x.x < 0) left = std::max(left, double(x.x));
  }
  return right - left;
}

// The jaws open at their tips by the requested gap.
TEST(Forceps, JawsOpenByRequestedGap) {
  const Forceps forceps = phantom();
  EXPECT_NEAR(tip_gap(forceps_mesh(forceps, 0.012)), 0.012, 5e-4);
  EXPECT_NEAR(tip_gap(forceps_mesh(forceps, 0.004)), 0.004, 5e-4);
  EXPECT_EQ(forceps_mesh(forceps, 0.01).triangles.size(), 348u);
}

// The jaws may be given in either order.
TEST(Forceps, JawOrderIsArbitrary) {
  const Forceps swapped = *build_forceps(phantom_forceps_half(true), phantom_forceps_half(false), 0.012);
  EXPECT_EQ(swapped.jaws[0].vertices, phantom().jaws[0].vertices);
}

// One surface with two components gives both jaws; one component alone is rejected.
TEST(Forceps, SplitsSurfaceOfBothJaws) {
  const Forceps both = *build_forceps(phantom_forceps(), 0.012);
  EXPECT_EQ(both.jaws[0].vertices, phantom().jaws[0].vertices);
  EXPECT_EQ(both.jaws[1].triangles, phantom().jaws[1].triangles);
  EXPECT_FALSE(build_forceps(phantom_forceps_half(false), 0.012)) << "one component only";
}

// Jaws that never meet, share a side or are not finite are rejected with a message.
TEST(Forceps, RejectsJawsThatNeverMeet) {
  const auto message = [](TriMesh a, TriMesh b, double opening) {
    const Result<Forceps> forceps = build_forceps(std::move(a), std::move(b), opening);
    return forceps ? std::string("built") : forceps.error().message;
  };
  const TriMesh right = phantom_forceps_half(false), left = phantom_forceps_half(true);
  TriMesh shifted = right;
  for (Vec3& x : shifted.vertices) x.x += 0.01f;
  EXPECT_EQ(
      message(shifted, left, 0.012),
      "the jaws never meet: when closed, they are 0.0101 m apart, expected at most a tenth of the opening "
      "of 0.012 m");
  EXPECT_EQ(message(right, right, 0.012),
            "expected one jaw on each side of the plane x = 0, found both on one side");
  EXPECT_EQ(message(right, {}, 0.012), "the second jaw has no triangles");
  EXPECT_NE(message(right, left, 0), "built");
  EXPECT_NE(message(right, left, 1), "built");
  TriMesh not_finite = left;
  not_finite.vertices[3].x = std::nanf("");
  EXPECT_NE(message(right, not_finite, 0.012), "built");
}

// The force stays continuous while forceps press, close on a fold, pull it and release it.
TEST(Forceps, GraspPullRelease_ForceIsContinuous) {
  const TriMesh mesh = phantom_liver();
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  const rhombus::Model model = *rhombus::build(std::move(body), {.bulge = 0.5});
  rhombus::State state = rhombus::make_state(model, 1);
  const RhombusTip forceps = rhombus_tip({}, phantom());
  const rhombus::FootPoint foot = rhombus::find_foot_point(model.surface, model.tree, {-0.04, 0.01, 0.2});
  const Vec3d across = normalized(cross(Vec3d{0, 1, 0}, foot.normal));
  const Mat3d axes{{across, cross(foot.normal, across), foot.normal}};
  double largest = 0, pulled = 0, squeezed = 0;
  Vec3d before;
  for (int i = 0; i < 4000; i++) {  // one second each: in by 3 mm, closing, out by 12 mm, opening
    const double fraction = i % 1000 * 1e-3;
    const double height = i < 1000   ? 1e-3 - 4e-3 * fraction
                          : i < 2000 ? -3e-3
                          : i < 3000 ? -3e-3 + 12e-3 * fraction
                                     : 9e-3;
    const double grip = i < 1000 ? 0 : i < 2000 ? fraction : i < 3000 ? 1 : 1 - (i - 3000) / 999.0;
    const Pose pose{foot.at.position + foot.normal * height, axes};
    const rhombus::TouchInput input = touch_input(forceps, pose, grip);
    rhombus::TouchForce force;
    rhombus::solve_touches(model, state, {&input, 1}, 1e-3, {&force, 1});
    largest = std::max(largest, norm(force.force - before));
    before = force.force;
    pulled = std::max(pulled, -dot(force.force, foot.normal));
    squeezed = std::max(squeezed, force.squeeze);
    EXPECT_EQ(force.holding, grip > 0) << i;
  }
  std::printf("forceps: pull %.4f N, squeeze %.4f N, largest jump per tick %.2e N\n", pulled, squeezed,
              largest);
  EXPECT_GT(pulled, 5e-3);
  EXPECT_GT(squeezed, 0);
  EXPECT_LT(largest, 0.01 * pulled);
  EXPECT_EQ(before, Vec3d{});
  EXPECT_EQ(rhombus::step(Exec(1), model, state).largest_displacement, 0);
}

}  // namespace
}  // namespace turgor::contact
