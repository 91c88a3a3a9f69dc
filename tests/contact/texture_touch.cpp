// Texture of each model's surface: the path of its vibration follows the material under the tool.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/contact/soft_block.hpp"
#include "tests/contact/spectrum.hpp"
#include "tests/models/rhombus/bodies.hpp"
#include "turgor/contact/local_contact.hpp"
#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/contact/sfem_touch.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3, kRadius = 5e-3;
const Texture kRough{{2e-6, 1e-3}};

double amplitude(double force) {
  return 2 * std::numbers::pi * force * kRough.waves.roughness / kRough.waves.wavelength;
}

// Rhombus chains ---------------------------------------------------------------------------------------

rhombus::Model chains(rhombus::Surface surface) {
  rhombus::Body body{.vertices = surface.vertices, .triangles = surface.triangles, .stiffness = {}};
  return *rhombus::build(std::move(body), {});
}

/// A ball on a rough surface of chains, and the same ball on a smooth one.
struct Chains {
  const rhombus::Model& model;
  RhombusTouch rough, smooth;
  std::vector<Vec3d> vibration, force;  // of every tick [N]

  explicit Chains(const rhombus::Model& made, Vec3d at, std::size_t tools = 1)
      : model(made), rough(ball(at, tools, kRough)), smooth(ball(at, tools, {})) {}
  static RhombusTouch ball(Vec3d at, std::size_t tools, const Texture& texture) {
    const std::vector<Pose> poses(tools, Pose{at, {}});
    return make_rhombus_touch(std::vector<RhombusTip>(tools, rhombus_tip(Sphere{kRadius}, {})), poses, {},
                              texture);
  }
  void tick(const std::vector<ToolCommand>& commands) {
    std::vector<ToolReading> with(commands.size()), without(commands.size());
    tick_rhombus_touch(model, rough, commands, kTick, with);
    tick_rhombus_touch(model, smooth, commands, kTick, without);
    vibration.push_back(with[0].force - without[0].force), force.push_back(without[0].force);
  }
  void tick(Vec3d at, double grip = 0) { tick({ToolCommand{{at, {}}, grip}}); }
};

// A ball that slides over a flat slab feels the frequency speed / wavelength with the amplitude 2π N a/λ,
// along its path, at each depth. A press without a slide has no vibration.
TEST(TextureTouch, ChainsVibrateBySpeedAndForce) {
  const rhombus::Model model = chains(rhombus::test::slab(0.2, 40, 0.35));
  double before = 0;
  for (const double depth : {2e-3, 6e-3}) {
    Chains slide(model, {-0.03, 0.002, kRadius});
    for (int i = 1; i <= 100; i++) slide.tick({-0.03, 0.002, kRadius - depth * i / 100});
    EXPECT_LT(largest_of(slide.vibration), 1e-9);
    slide.vibration.clear();
    for (int i = 1; i <= 1000; i++) slide.tick({-0.03 + 6.1e-5 * i, 0.002, kRadius - depth});
    EXPECT_EQ(peak_of(slide.vibration, {1, 0, 0}), 61);
    const double normal = slide.force.back().z;
    EXPECT_NEAR(largest_of(slide.vibration), amplitude(normal), 0.02 * amplitude(normal));
    for (const Vec3d f : slide.vibration) EXPECT_NEAR(norm(f - Vec3d{f.x, 0, 0}), 0, 1e-9);
    EXPECT_GT(normal, 1.5 * before);
    before = normal;
  }
}

// On a curved organ the phase is the path of the foot on the surface at rest over the wavelength, although
// the tool itself, which is pressed in, moves a shorter one.
TEST(TextureTouch, ChainsPhaseIsPathOnSurfaceAtRest) {
  constexpr double kOrgan = 0.06, kDepth = 6e-3;
  const rhombus::Model model = chains(rhombus::test::sphere(kOrgan, 4));
  const auto at = [&](int n) {
    const double angle = n * 2.5e-4;
    return Vec3d{std::sin(angle), 0, std::cos(angle)} * (kOrgan + kRadius - kDepth);
  };
  Chains slide(model, at(0));
  slide.tick(at(0));
  double waves = 0, phase = slide.rough.textures[0].phase;
  for (int n = 1; n <= 2000; n++) {
    slide.tick(at(n));
    const double now = slide.rough.textures[0].phase;
    waves += now - phase + (now < phase ? 1 : 0);
    phase = now;
  }
  EXPECT_NEAR(waves, kOrgan * 2000 * 2.5e-4 / kRough.waves.wavelength, 0.3);
  EXPECT_GT(largest_of(slide.vibration), 0.1 * amplitude(norm(slide.force.back())));
}

// Tissue that another tool deforms beside a resting ball, and tissue that a grasp carries, do not vibrate.
TEST(TextureTouch, DeformedChainsDoNotVibrate) {
  const rhombus::Model model = chains(rhombus::test::slab(0.2, 40, 0.35));
  Chains pressed(model, {0, 0, kRadius}, 2);
  const ToolCommand rest{{{0, 0, kRadius - 3e-3}, {}}};
  const auto beside = [](int i) { return ToolCommand{{{0.012, 0, kRadius + 2e-3 - 2e-5 * i}, {}}}; };
  for (int i = 0; i <= 300; i++) pressed.tick({rest, beside(i)});
  EXPECT_GT(norm(pressed.force.back() - pressed.force.front()), 1e-5) << "the other tool deforms the tissue";
  EXPECT_EQ(largest_of(pressed.vibration), 0);
  Chains held(model, {0, 0, kRadius});
  for (int i = 0; i <= 300; i++) held.tick({1e-5 * std::max(0, i - 100), 0, kRadius - 3e-3}, i > 50 ? 1 : 0);
  EXPECT_GT(std::abs(held.force.back().x), 1e-4) << "the grasp pulls";
  EXPECT_EQ(largest_of(held.vibration), 0);
}

// Ticks on a rough surface with a map of heights allocate nothing.
TEST(TextureTouch, ChainsAllocateNothing) {
  const rhombus::Model model = chains(rhombus::test::slab(0.2, 40, 0.35));
  std::vector<double> heights;
  for (int i = 0; i < 64; i++) heights.push_back(2e-6 * std::sin(i * i));
  const Texture texture{.waves = {},
                        .map = std::make_shared<const HeightMap>(make_height_map(8, 8, 1e-3, heights))};
  RhombusTouch touch = Chains::ball({0, 0, kRadius - 3e-3}, 1, texture);
  latest<RhombusTissue> tissue;
  latest<RhombusTouchSnapshot> touched;
  prepare(touch, touched);
  std::vector<ToolReading> readings(1);
  std::size_t counted = 0;
  for (int i = 0; i < 300; i++) {
    const ToolCommand command{{{5e-5 * i, 3e-5 * i, kRadius - 3e-3}, {}}};
    counted += test::allocations_of(
        [&] { tick_and_publish(model, touch, tissue, touched, std::span(&command, 1), kTick, readings); });
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_GT(touched.read().textures[0].largest_force, 0);
}

// Finite elements --------------------------------------------------------------------------------------

/// A ball on a block of finite elements that may move as a whole.
struct Elements {
  SfemTouch rough, smooth;
  std::vector<Vec3d> vibration, force;

  Elements(double friction, Vec3d at) : rough(ball(friction, at, kRough)), smooth(ball(friction, at, {})) {}
  static SfemTouch ball(double friction, Vec3d at, const Texture& texture) {
    const std::vector<Vec3d> positions{{0, 0, 0}};
    auto patch = std::make_shared<const sfem::Patch>(
        *sfem::build_patch(soft_block(), sfem::patch_elements(soft_block(), positions, 0.016), 2, positions));
    return make_sfem_touch(std::move(patch), {{Sphere{kRadius}, friction}}, std::vector<Pose>{{at, {}}},
                           {.touch = {},
                            .follow = {},
                            .vertex_count = soft_block().body.mesh.vertices.size(),
                            .texture = texture});
  }
  void tick(Vec3d at, Vec3d of_block) {
    std::vector<ToolReading> with(1), without(1);
    const std::vector<ToolCommand> command{{{at, {}}}};
    for (auto* touch : {&rough, &smooth}) {
      take_free_motion(*touch, std::vector<Vec3d>(touch->free.to.size(), of_block), 1);
      tick_sfem_touch(*touch, command, kTick, touch == &rough ? with : without);
    }
    vibration.push_back(with[0].force - without[0].force), force.push_back(without[0].force);
  }
};

// A ball that slides over a body, and a body that slides under a resting ball, feel the same frequency.
TEST(TextureTouch, ElementsVibrateByRelativeMotion) {
  for (const bool body_moves : {false, true}) {
    Elements slide(0.05, {0, 1e-3, kRadius});
    const auto slide_to = [&](double x, double depth) {
      const Vec3d step{x, 0, 0};
      slide.tick({body_moves ? 0 : x, 1e-3, kRadius - depth}, body_moves ? -step : Vec3d{});
    };
    for (int i = 1; i <= 100; i++) slide_to(0, 1.5e-5 * i);
    slide.vibration.clear();  // the first sites of a press are oblique
    for (int i = 1; i <= 500; i++) slide_to(1.4e-5 * i, 1.5e-3);
    EXPECT_NEAR(peak_of(slide.vibration, {1, 0, 0}), 14, 1) << body_moves;
    const double normal = norm(slide.force.back());
    EXPECT_NEAR(largest_of(slide.vibration), amplitude(normal), 0.1 * amplitude(normal));
  }
}

// A body that moves together with the tool, and one that sticks to it, have slid no path.
TEST(TextureTouch, ElementsThatFollowDoNotVibrate) {
  Elements together(0.05, {0, 1e-3, kRadius}), stuck(5, {0, 1e-3, kRadius});
  for (int i = 1; i <= 100; i++)
    for (Elements* press : {&together, &stuck}) press->tick({0, 1e-3, kRadius - 1.5e-5 * i}, {});
  together.vibration.clear();
  const double phase = together.rough.textures[0].phase;
  for (int i = 1; i <= 300; i++) {
    const double x = 1.4e-5 * i;
    together.tick({x, 1e-3, kRadius - 1.5e-3}, {x, 0, 0});
    stuck.tick({0.2 * x, 1e-3, kRadius - 1.5e-3}, {});
  }
  EXPECT_LT(largest_of(together.vibration), 1e-9);
  EXPECT_EQ(together.rough.textures[0].phase, phase);
  EXPECT_EQ(largest_of(stuck.vibration), 0);
  EXPECT_GT(std::abs(stuck.force.back().x), 0.01) << "N: the surface is dragged along";
}

// The vibration acts at the contact: of a rod of half length 5 cm that slides upright, the torque vibrates by
// the arm from its middle to its tip times the force.
TEST(TextureTouch, VibrationOfElementsHasTorque) {
  constexpr double kHalf = 0.05, kDepth = 1.5e-3;
  const auto rod = [](const Texture& texture) {
    SfemTouch touch = Elements::ball(0, {0, 1e-3, kRadius}, texture);
    touch.tools[0].shape = Capsule{kRadius, kHalf};
    return touch;
  };
  SfemTouch rough = rod(kRough), smooth = rod({});
  double largest = 0, normal = 0;
  for (int i = 1; i <= 400; i++) {
    const Vec3d at{1.4e-5 * std::max(0, i - 100), 1e-3, kHalf + kRadius - kDepth * std::min(1.0, i / 100.0)};
    const std::vector<ToolCommand> command{{{at, {}}}};
    std::vector<ToolReading> with(1), without(1);
    tick_sfem_touch(rough, command, kTick, with), tick_sfem_touch(smooth, command, kTick, without);
    const Vec3d force = with[0].force - without[0].force, torque = with[0].torque - without[0].torque;
    const Vec3d expected = cross(Vec3d{0, 0, -(kHalf + kRadius)}, force);
    largest = std::max(largest, norm(torque)), normal = without[0].force.z;
    if (i <= 110) continue;
    EXPECT_LT(norm(torque - expected), 0.05 * norm(expected) + 1e-9) << i;
  }
  EXPECT_NEAR(largest, (kHalf + kRadius) * amplitude(normal), 0.1 * largest);
  EXPECT_GT(normal, 0.01);
}

// Local contacts ---------------------------------------------------------------------------------------

LocalContact plane_at(double x, double friction) {
  return {.is_near = true,
          .origin = {x, 0, -1e-3},
          .normal = {0, 0, 1},
          .force = {0, 0, 0.3},
          .stiffness = 300,
          .shear_stiffness = 200,
          .friction = friction,
          .reach = 0.05,
          .waves = kRough.waves};
}

/// A tool that slides along x over planes of frames of 16 ticks, with the vibration of every tick.
struct Slide {
  LocalTouch rough, smooth;
  std::vector<Vec3d> vibration;

  void run(int ticks, double step, double friction, bool is_carried = false) {
    for (int i = 0; i < ticks; i++) {
      const double x = step * i;
      if (i % 16 == 0)
        for (LocalTouch* touch : {&rough, &smooth}) {
          LocalContact plane = plane_at(is_carried ? x : std::max(0.0, x - 16 * step), friction);
          if (!is_carried && friction > 0 && i > 0) plane.force.x = -friction * 0.3;
          if (touch == &smooth) plane.waves = {};
          update_contact(*touch, plane);
        }
      ToolReading with, without;
      tick_local_touch(rough, {.pose = {{x, 0, -1e-3}, {}}}, kTick, with);
      tick_local_touch(smooth, {.pose = {{x, 0, -1e-3}, {}}}, kTick, without);
      vibration.push_back(with.force - without.force);
    }
  }
};

// Between frames a tool that slides over the plane feels the frequency speed / wavelength with the amplitude
// 2π N a/λ, with and without friction. Each new plane continues the phase.
TEST(TextureTouch, PlanesVibrateBySpeedAndForce) {
  for (const double friction : {0.0, 0.3}) {
    Slide slide;
    slide.run(1000, 4.3e-5, friction);
    EXPECT_NEAR(peak_of(slide.vibration, {1, 0, 0}), 43, 1) << friction;
    EXPECT_NEAR(largest_of(slide.vibration), amplitude(0.3), 0.03 * amplitude(0.3)) << friction;
    EXPECT_NEAR(slide.rough.texture.largest_rate, 43, 1) << friction;
    EXPECT_EQ(slide.smooth.texture.largest_force, 0);
  }
}

// Tissue that sticks to the tool and moves with it has slid no path, nor has a tool that moves less than
// friction bears.
TEST(TextureTouch, PlanesThatFollowDoNotVibrate) {
  Slide carried, stuck;
  carried.run(500, 2e-5, 5, true);
  stuck.run(16, 2e-5, 5);
  EXPECT_LT(largest_of(carried.vibration), 1e-12);
  EXPECT_LT(largest_of(stuck.vibration), 1e-12);
}

// A teleported tool begins a new contact and keeps the statistics.
TEST(TextureTouch, TeleportKeepsStatistics) {
  Slide slide;
  slide.run(200, 4.3e-5, 0);
  const TextureState before = slide.rough.texture;
  EXPECT_GT(before.largest_force, 0);
  end_contact(slide.rough);
  EXPECT_FALSE(slide.rough.texture.is_touching);
  EXPECT_FALSE(slide.rough.seen);
  EXPECT_EQ(slide.rough.texture.largest_force, before.largest_force);
}

}  // namespace
}  // namespace turgor::contact
