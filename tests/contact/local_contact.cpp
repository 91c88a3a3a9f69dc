#include "turgor/contact/local_contact.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/block_body.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3, kFrame = 1.0 / 60, kYoung = 4e3;
constexpr int kTicks = 17;  // per frame

/// Tool position as a function of time.
using Path = std::function<Vec3d(double time)>;

/// A body that a ball touches, with the forces of frames and of ticks.
struct HapticRun {
  LocalTouch touch;
  LocalContactHistory memory;
  std::vector<Vec3d> by_frame,
      by_tick;  // on the tool at the end of each frame: of the frame's solve, and haptic [N]
  double steepest = 0, most_rubbing = 0, least_push = 0, largest = 0;
  std::size_t allocations = 0;

  /// Frames of 17 ticks. The contact of a frame is used one frame later, as when frames run beside the ticks.
  void run(const Path& path, double from, double to, const std::function<LocalContact(const Pose&)>& frame) {
    for (int n = 0; n < int(std::lround((to - from) / (kTicks * kTick))); n++) {
      const double begin = from + n * kTicks * kTick;
      const LocalContact made = frame({path(begin), {}});
      if (n > 0) by_frame.push_back(made.force), by_tick.push_back(touch.force);
      largest = std::max(largest, norm(made.force));
      for (int i = 1; i <= kTicks; i++) tick_at(path(begin + i * kTick));
      allocations += test::allocations_of([&] { update_contact(touch, made); });
    }
  }
  void tick_at(Vec3d position) {
    const Vec3d before = touch.force;
    ToolReading reading;
    allocations += test::allocations_of([&] {
      tick_local_touch(touch, {.pose = {position, {}}}, kTick, reading);
    });
    steepest = std::max(steepest, norm(touch.force - before));
    const double push = dot(reading.force, touch.contact.normal);
    least_push = std::min(least_push, push);
    const double rubbing = norm(reading.force - touch.contact.normal * push);
    if (push > 0) most_rubbing = std::max(most_rubbing, rubbing / push);
    EXPECT_LE(rubbing, touch.contact.friction * std::max(push, 0.0) * (1 + 1e-9) + 1e-12);
  }
  double worst() const {
    double deviation = 0;
    for (std::size_t n = 0; n < by_tick.size(); n++)
      deviation = std::max(deviation, norm(by_tick[n] - by_frame[n]));
    return deviation;
  }
};

/// A block of tissue, fixed at its bottom, under a ball.
struct Tissue {
  Int3 size;
  double step = 0, radius = 0;  // [m]
  double friction = 0.4;
  Mat3d axes{};    // of its lattice in the patient
  Vec3d origin{};  // [m]
  lattice::Model model{};
  lattice::State state{};
  LatticeTouch touch{};
  std::vector<ToolForce> forces{1};

  lattice::BodySurface surface{};

  Tool tool() const { return {Sphere{radius}, friction}; }
  /// Builds the block; returns the center of its top.
  Vec3d build() {
    lattice::Params params;
    params.skin.enabled = false;
    params.solver = {.sweeps = 20, .damping = 8};
    model = lattice::block_model(
        {.size = size, .spacing = step, .young = kYoung, .is_fixed = [](Int3 p) { return p.z == 0; }},
        params);
    model.anatomy.grid.axes = axes, model.anatomy.grid.origin = origin;
    state = lattice::make_state(model);
    surface = lattice::build_surface(model, state.cuts);
    double top = 0;
    for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
    return origin + axes * Vec3d{0.5 * (size.x - 1) * step, 0.5 * (size.y - 1) * step, top};
  }
  void begin(Vec3d at) {
    const std::vector<ToolPose> poses{{{at, {}}, false}};
    touch = make_lattice_touch(model, state.cuts, surface, poses);
  }
  LocalContact frame(const Pose& pose, LocalContactHistory& memory) {
    const std::vector<Tool> tools{tool()};
    const std::vector<ToolPose> poses{{pose, false}};
    EXPECT_TRUE(step_to(tools, poses));
    return local_contact(model, state.motion, touch, 0, tools[0], poses[0], memory);
  }
  bool step_to(const std::vector<Tool>& tools, const std::vector<ToolPose>& poses) {
    return contact::step_with_tools(Exec(2), model, state, touch, tools, poses, {}, kFrame, forces).finite;
  }
};

/// Presses to a depth at a speed, stays for a while, and retracts ten times as fast.
Path press(Vec3d surface, Vec3d inwards, double depth, double speed) {
  const double clearance = 0.002, hold = 0.8, in = (depth + clearance) / speed;
  return [=](double time) {
    const double out = std::max(0.0, time - in - hold) * 10 * speed;
    return surface + inwards * (std::min(time, in) * speed - clearance - std::min(out, 4 * depth));
  };
}

void expect_slow_press_like_its_frames(Tissue tissue, Vec3d inwards, double depth) {
  constexpr double kSpeed = 0.005;
  const Vec3d surface = tissue.build();
  const double in = (depth + 0.002) / kSpeed;
  const Path path = press(surface - inwards * tissue.radius, inwards, depth, kSpeed);
  tissue.begin(path(0));
  HapticRun haptic;
  const auto frame = [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); };
  haptic.run(path, 0, in + 0.8, frame);
  const double pressed = haptic.worst(), jump = haptic.touch.largest_jump,
               rest = norm(haptic.by_tick.back() - haptic.by_frame.back());
  haptic.run(path, in + 0.8, in + 1.6, frame);
  std::printf(
      "ball of %.0f mm, %.0f mm in: %.4f N; error between frames %.4f N, at rest %.1e N; a new "
      "plane "
      "jumps by up to %.4f N, blended to at most %.5f N per tick\n",
      tissue.radius * 1e3, depth * 1e3, haptic.largest, pressed, rest, jump, haptic.steepest);
  EXPECT_GT(haptic.largest, 0.01) << "N";
  EXPECT_LT(pressed, 0.05 * haptic.largest);
  EXPECT_LT(rest, 1e-3 * haptic.largest);
  EXPECT_LT(jump, 0.05 * haptic.largest);
  EXPECT_LT(haptic.touch.largest_jump, 0.3 * haptic.largest) << "while the tool retracts ten times as fast";
  EXPECT_LT(haptic.steepest, 0.1 * haptic.largest) << "while the tool retracts";
  EXPECT_GE(haptic.least_push, 0) << "no adhesion";
  EXPECT_LE(haptic.most_rubbing, tissue.friction * (1 + 1e-9));
  EXPECT_EQ(haptic.touch.force, Vec3d{}) << "no contact";
  EXPECT_EQ(haptic.allocations, 0u);
}

// The haptic force of a slow press on a lattice follows the forces of its frames.
TEST(LocalContact, SlowPressMatchesFrames) {
  expect_slow_press_like_its_frames({.size = {21, 21, 11}, .step = 0.004, .radius = 0.012}, {0, 0, -1},
                                    0.004);
  expect_slow_press_like_its_frames({.size = {15, 17, 13}, .step = 0.006, .radius = 0.02, .friction = 0.2},
                                    normalized(Vec3d{0.3, 0.1, -1}), 0.0045);
}

/// An oblique press by 3 mm: the haptic force at the end of every frame, in the lattice's axes.
std::vector<Vec3d> haptic_forces_in_lattice(const Mat3d& axes, Vec3d origin) {
  Tissue tissue{.size = {15, 15, 9}, .step = 0.004, .radius = 0.012, .axes = axes, .origin = origin};
  const Vec3d middle = tissue.build(), inwards = axes * normalized(Vec3d{0.4, -0.2, -1});
  const Path path = press(middle + axes * Vec3d{0, 0, tissue.radius}, inwards, 0.003, 0.01);
  tissue.begin(path(0));
  HapticRun haptic;
  haptic.run(path, 0, 0.6, [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); });
  EXPECT_LT(norm(haptic.touch.contact.force - tissue.forces[0].force), 1e-9)
      << "the sum of the frame's contacts";
  std::vector<Vec3d> all;
  for (const Vec3d force : haptic.by_tick) all.push_back(transposed(axes) * force);
  return all;
}

// A lattice that is rotated in the patient gives the same haptic force.
TEST(LocalContact, RotatedLatticeKeepsForce) {
  const Mat3d turned{{{0, 0.8, 0.6}, {0, -0.6, 0.8}, {1, 0, 0}}};
  const std::vector<Vec3d> straight = haptic_forces_in_lattice({}, {}),
                           other = haptic_forces_in_lattice(turned, {0.3, -0.2, 0.7});
  ASSERT_EQ(straight.size(), other.size());
  double largest = 0;
  for (std::size_t n = 0; n < straight.size(); n++) {
    largest = std::max(largest, norm(straight[n]));
    EXPECT_LT(norm(straight[n] - other[n]), 0.01 * largest + 1e-5) << n << ": the CT's axes change no force";
  }
  EXPECT_GT(largest, 0.01) << "N";
}

// The friction of a dragged ball stays within Coulomb's cone.
TEST(LocalContact, DraggedBallStaysInCone) {
  Tissue tissue{.size = {31, 21, 11}, .step = 0.004, .radius = 0.012, .friction = 0.3};
  const Vec3d middle = tissue.build();
  const Path path = [&](double time) {
    const double depth = 0.003 * std::min(1.0, time / 0.5), along = 0.03 * std::max(0.0, time - 0.6);
    return middle + Vec3d{along - 0.02, 0, tissue.radius - depth};
  };
  tissue.begin(path(0));
  HapticRun haptic;
  haptic.run(path, 0, 1.8, [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); });
  std::printf("dragged: friction %.3f of the normal force, %.5f N per tick of %.4f N\n", haptic.most_rubbing,
              haptic.steepest, haptic.largest);
  EXPECT_LE(haptic.most_rubbing, 0.3 * (1 + 1e-9));
  EXPECT_GT(haptic.most_rubbing, 0.25) << "sliding";
  EXPECT_LT(haptic.steepest, 0.05 * haptic.largest);
}

// Between two frames, the force follows the stiffness and the friction of the plane.
TEST(LocalContact, ForceFollowsPlaneStiffness) {
  const LocalContact plane{.is_near = true,
                           .normal = {0, 0, 1},
                           .force = {0, 0, 0.5},
                           .stiffness = 200,
                           .shear_stiffness = 100,
                           .friction = 0.4,
                           .reach = 0.01};
  LocalTouch touch{.params = {.damping = 0}};
  update_contact(touch, plane);
  ToolReading reading;
  const auto at = [&](Vec3d position) {
    tick_local_touch(touch, {.pose = {position, {}}}, kTick, reading);
    return reading.force;
  };
  EXPECT_LT(norm(at({0, 0, 0}) - Vec3d{0, 0, 0.5}), 1e-12);
  EXPECT_LT(norm(at({0, 0, -0.001}) - Vec3d{0, 0, 0.7}), 1e-12);
  EXPECT_LT(norm(at({0.001, 0, 0}) - Vec3d{-0.1, 0, 0.5}), 1e-12) << "sticking";
  EXPECT_LT(norm(at({0.005, 0, 0}) - Vec3d{-0.2, 0, 0.5}), 1e-12) << "sliding";
  EXPECT_LT(norm(at({0.004, 0, 0}) - Vec3d{-0.1, 0, 0.5}), 1e-12) << "sticking again after the slide";
  EXPECT_EQ(at({0, 0, 0.0026}), Vec3d{}) << "separated from the plane";
  EXPECT_LT(norm(at({0, 0, -0.05}) - Vec3d{0, 0, 2.5}), 1e-12) << "clamped to the reach of the plane";
  EXPECT_TRUE(reading.beyond_patch);
  EXPECT_EQ(at({NAN, 0, 0}), Vec3d{});
}

// A new plane is blended in without a jump; the blend ends with the contact.
TEST(LocalContact, NewPlaneIsBlendedIn) {
  LocalContact plane{.is_near = true, .force = {0, 0, 0.5}, .stiffness = 200, .reach = 0.01};
  LocalTouch touch{.params = {.blend_time = 0.02, .largest_step = 0.005}};
  ToolReading reading;
  update_contact(touch, plane);
  for (int i = 0; i < 10; i++) tick_local_touch(touch, {}, kTick, reading);
  plane.force = {0, 0, 0.3};
  update_contact(touch, plane);
  EXPECT_NEAR(touch.largest_jump, 0.2, 1e-12);
  double before = reading.force.z;
  for (int i = 0; i < 200; i++) {
    tick_local_touch(touch, {}, kTick, reading);
    EXPECT_LE(before - reading.force.z, 0.005 + 1e-12) << i;
    before = reading.force.z;
  }
  EXPECT_NEAR(before, 0.3, 1e-4);
  plane.force = {0, 0, 0.6};
  update_contact(touch, plane);
  tick_local_touch(touch, {.pose = {{0, 0, 0.004}, {}}}, kTick, reading);
  EXPECT_EQ(reading.force, Vec3d{}) << "the rest of a jump does not pull a separated tool";
}

/// A sheet that is held along all its edges, with a ball above its center.
struct Sheet {
  int n;
  double spacing;
  Shape ball = Sphere{0.03};
  cloth::Model model{};
  cloth::State state{};
  Pose at{};

  void begin() {
    cloth::Params params;
    params.collision.thickness = 0.4 * spacing;
    model = cloth::must_build(cloth::flat_sheet(n, spacing), params);
    state = cloth::make_state(model);
    for (int i = 0; i < n; i++)
      for (const int v : {i, (n - 1) * n + i, i * n, i * n + n - 1}) (void)cloth::hold(model, state, v);
  }
  LocalContact frame(const Pose& to, LocalContactHistory& memory) {
    cloth::Inputs inputs = cloth::in_vacuum(0);
    inputs.obstacles.push_back(cloth_obstacle(ball, at, to, kFrame));
    inputs.obstacles[0].friction = 0.3;
    EXPECT_TRUE(cloth::step(Exec(2), model, state, inputs, kFrame).finite);
    at = to;
    return local_contact(model, state, 0, inputs.obstacles[0].gap, {ball, 0.3}, to, kFrame, memory);
  }
};

// The haptic force of a ball on a taut sheet follows the forces of its frames.
TEST(LocalContact, TautSheetMatchesFrames) {
  for (Sheet sheet :
       {Sheet{.n = 25, .spacing = 0.01}, Sheet{.n = 17, .spacing = 0.02, .ball = Sphere{0.05}}}) {
    sheet.begin();
    const double radius = bounding_radius(sheet.ball), middle = 0.5 * (sheet.n - 1) * sheet.spacing;
    const Path path = press({middle, middle, radius + 0.002}, {0, 0, -1}, 0.02, 0.04);
    sheet.at = {path(0), {}};
    HapticRun haptic;
    const auto frame = [&](const Pose& pose) { return sheet.frame(pose, haptic.memory); };
    haptic.run(path, 0, 1.3, frame);
    const double rest = norm(haptic.by_tick.back() - haptic.by_frame.back());
    std::printf("sheet: %.4f N, error between frames %.4f N, at rest %.1e N; %.5f N a tick\n", haptic.largest,
                haptic.worst(), rest, haptic.steepest);
    EXPECT_GT(haptic.by_frame.back().z, 0.01) << "N: the sheet carries the ball";
    EXPECT_LT(rest, 0.02 * haptic.largest);
    EXPECT_LT(haptic.worst(), 0.25 * haptic.largest) << "while the sheet swings";
    haptic.run(path, 1.3, 2.2, frame);
    EXPECT_GE(haptic.least_push, 0);
    EXPECT_LE(haptic.most_rubbing, 0.3 * (1 + 1e-9));
    EXPECT_EQ(haptic.touch.force, Vec3d{}) << "N: no contact";
    EXPECT_EQ(haptic.allocations, 0u);
  }
}

// A light sheet that swings against a resting ball presses it by less than the reach of the plane.
TEST(LocalContact, ImpactOfSheetHasSmallDepth) {
  Sheet sheet{.n = 25, .spacing = 0.01};
  sheet.begin();
  const double middle = 0.5 * (sheet.n - 1) * sheet.spacing;
  sheet.at = {{middle, middle, bounding_radius(sheet.ball) + 0.02}, {}};
  std::fill_n(sheet.state.v.z.begin(), sheet.model.count, Real(5));  // m/s
  LocalContactHistory memory;
  LocalTouch touch;
  ToolReading reading;
  double deepest = 0, strongest = 0, reach = 0;
  for (int n = 0; n < 10; n++) {
    const LocalContact plane = sheet.frame(sheet.at, memory);
    strongest = std::max(strongest, norm(plane.force)), reach = plane.reach;
    update_contact(touch, plane);
    for (int i = 0; i < kTicks; i++) tick_local_touch(touch, {.pose = sheet.at}, kTick, reading);
    deepest = std::max(deepest, reading.depth);
  }
  EXPECT_GT(strongest, 0.1) << "N: the sheet hits the ball";
  std::printf("sheet: %.3f N, %.1f mm deep of %.1f\n", strongest, 1e3 * deepest, 1e3 * reach);
  EXPECT_GT(deepest, 0) << "m";
  EXPECT_LE(deepest, reach * (1 + 1e-9)) << "m";
}

}  // namespace
}  // namespace turgor::contact
