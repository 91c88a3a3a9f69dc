#include "turgor/contact/rhombus_touch.hpp"

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "turgor/geometry/phantom_liver.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3;

rhombus::Model liver(double tear = 30) {
  const TriMesh mesh = phantom_liver();
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  return *rhombus::build(std::move(body), {.tear = tear});
}

Forceps jaws() { return *build_forceps(phantom_forceps_half(false), phantom_forceps_half(true), 0.012); }

/// Forceps that press, close, pull by 12 mm and open, one second each, and a ball that presses beside them.
struct Hands {
  rhombus::FootPoint at, beside;
  double grip = 0;

  explicit Hands(const rhombus::Model& model)
      : at(rhombus::find_foot_point(model.surface, model.tree, {-0.04, 0.01, 0.2})),
        beside(rhombus::find_foot_point(model.surface, model.tree, {0.02, 0.01, 0.2})) {}
  std::array<ToolCommand, 2> next(int tick) {
    const double fraction = tick % 1000 * 1e-3;
    const double height = tick < 1000   ? 1e-3 - 4e-3 * fraction
                          : tick < 2000 ? -3e-3
                          : tick < 3000 ? -3e-3 + 12e-3 * fraction
                                        : 9e-3;
    const bool hold = tick >= 1000 && tick < 3000;
    grip = next_grip(grip, hold, 0.3, kTick);
    const Vec3d across = normalized(cross(Vec3d{0, 1, 0}, at.normal));
    const Mat3d axes{{across, cross(at.normal, across), at.normal}};
    return {ToolCommand{{at.at.position + at.normal * height, axes}, grip, hold},
            ToolCommand{{beside.at.position + beside.normal * (4e-3 - 3e-6 * tick), {}}, 0, false}};
  }
};

RhombusTouch touched(Hands& hands) {
  const auto commands = hands.next(0);
  return make_rhombus_touch({rhombus_tip({}, jaws()), rhombus_tip(Sphere{5e-3}, {})},
                            std::array{commands[0].pose, commands[1].pose}, {});
}

// Forceps and a ball have contact forces, and a tick allocates no memory.
TEST(RhombusToolTouch, TicksAllocateNothing) {
  const rhombus::Model model = liver();
  Hands hands(model);
  RhombusTouch touch = touched(hands);
  latest<RhombusTissue> tissue;
  latest<RhombusTouchSnapshot> touched_now;
  prepare(touch, touched_now);
  std::vector<ToolReading> readings(2);
  std::size_t counted = 0;
  double pressed = 0, pulled = 0, squeezed = 0;
  for (int i = 1; i < 4000; i++) {
    const auto commands = hands.next(i);
    counted += test::allocations_of(
        [&] { tick_and_publish(model, touch, tissue, touched_now, commands, kTick, readings); });
    const double along = dot(readings[0].force, hands.at.normal);
    pressed = std::max(pressed, along), pulled = std::max(pulled, -along);
    squeezed = std::max(squeezed, readings[0].squeeze);
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_GT(pressed, 1e-3) << "N";
  EXPECT_GT(pulled, 5e-3) << "N";
  EXPECT_GT(squeezed, 0) << "N";
  EXPECT_EQ(readings[0].force, Vec3d{}) << "released";
  EXPECT_NEAR(readings[1].depth, 5e-3 + 3e-6 * 3999 - 4e-3, 1e-3) << "m: the ball's lowest point";
  EXPECT_EQ(touched_now.read().touches.size(), 2u);
}

// Tissue slips out of the jaws once at the tear force, which bounds the pull.
TEST(RhombusToolTouch, TissueSlipsAtTearForce) {
  const rhombus::Model model = liver(5e-3);
  Hands hands(model);
  RhombusTouch touch = touched(hands);
  std::vector<ToolReading> readings(2);
  int slips = 0;
  double largest = 0;
  for (int i = 1; i < 4000; i++) {
    tick_rhombus_touch(model, touch, hands.next(i), kTick, readings);
    slips += touch.forces[0].slipped;
    largest = std::max(largest, norm(readings[0].force));
  }
  EXPECT_EQ(slips, 1);
  EXPECT_LE(largest, 5e-3 * (1 + 1e-12));
}

}  // namespace
}  // namespace turgor::contact
