#include "turgor/contact/local_contact.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/block_body.hpp"
#include "turgor/contact/cloth_obstacle.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3, kFrame = 1.0 / 60, kYoung = 4e3;
constexpr int kTicks = 17;  // of a frame

/// Where a tool is at a time.
using Way = std::function<Vec3d(double time)>;

/// A body that a ball touches: by its frames, and from them by its ticks.
struct Felt {
  LocalTouch touch;
  LocalMemory memory;
  std::vector<Vec3d> by_frame, by_tick;  // on the tool at the end of each frame: solved there, and felt [N]
  double steepest = 0, most_rubbing = 0, least_push = 0, largest = 0;
  std::size_t allocations = 0;

  /// Frames of 17 ticks. What a frame finds is there one frame later, as when it is made beside the ticks.
  void go(const Way& way, double from, double to, const std::function<LocalContact(const Pose&)>& frame) {
    for (int n = 0; n < int(std::lround((to - from) / (kTicks * kTick))); n++) {
      const double begin = from + n * kTicks * kTick;
      const LocalContact made = frame({way(begin), {}});
      if (n > 0) by_frame.push_back(made.force), by_tick.push_back(touch.force);
      largest = std::max(largest, norm(made.force));
      for (int i = 1; i <= kTicks; i++) tick_at(way(begin + i * kTick));
      allocations += test::allocations_of([&] { take(touch, made); });
    }
  }
  void tick_at(Vec3d place) {
    const Vec3d before = touch.force;
    ToolReading reading;
    allocations += test::allocations_of([&] { tick(touch, {.pose = {place, {}}}, kTick, reading); });
    steepest = std::max(steepest, norm(touch.force - before));
    const double push = dot(reading.force, touch.contact.normal);
    least_push = std::min(least_push, push);
    const double rubbing = norm(reading.force - touch.contact.normal * push);
    if (push > 0) most_rubbing = std::max(most_rubbing, rubbing / push);
    EXPECT_LE(rubbing, touch.contact.friction * std::max(push, 0.0) * (1 + 1e-9) + 1e-12);
  }
  double worst() const {
    double off = 0;
    for (std::size_t n = 0; n < by_tick.size(); n++) off = std::max(off, norm(by_tick[n] - by_frame[n]));
    return off;
  }
};

/// A block of tissue that a ball touches, held at its bottom.
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
  /// The middle of its top.
  Vec3d build() {
    lattice::Params params;
    params.skin.enabled = false;
    params.solver = {.sweeps = 20, .damping = 8};
    model = lattice::block_model(
        {.size = size, .step = step, .young = kYoung, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
    model.grid.axes = axes, model.grid.origin = origin;
    state = lattice::make_state(model);
    surface = lattice::build_surface(model, state);
    double top = 0;
    for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
    return origin + axes * Vec3d{0.5 * (size.x - 1) * step, 0.5 * (size.y - 1) * step, top};
  }
  void begin(Vec3d at) {
    const std::vector<ToolPose> poses{{{at, {}}, false}};
    touch = make_lattice_touch(model, state, surface, poses);
  }
  LocalContact frame(const Pose& pose, LocalMemory& memory) {
    const std::vector<Tool> tools{tool()};
    const std::vector<ToolPose> poses{{pose, false}};
    EXPECT_TRUE(step_to(tools, poses));
    return local_contact(model, state, touch, 0, tools[0], poses[0], memory);
  }
  bool step_to(const std::vector<Tool>& tools, const std::vector<ToolPose>& poses) {
    return contact::step(Exec(2), model, state, touch, tools, poses, {}, kFrame, forces).finite;
  }
};

/// In at a speed until a depth, there for a while, and out again ten times as fast.
Way press(Vec3d surface, Vec3d inwards, double depth, double speed) {
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
  const Way way = press(surface - inwards * tissue.radius, inwards, depth, kSpeed);
  tissue.begin(way(0));
  Felt haptic;
  const auto frame = [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); };
  haptic.go(way, 0, in + 0.8, frame);
  const double pressed = haptic.worst(), jump = haptic.touch.largest_jump,
               rest = norm(haptic.by_tick.back() - haptic.by_frame.back());
  haptic.go(way, in + 0.8, in + 1.6, frame);
  std::printf(
      "ball of %.0f mm, %.0f mm in: %.4f N; between frames off by %.4f N, at rest by %.1e N; a new plane "
      "jumps by up to %.4f N, felt as at most %.5f N a tick\n",
      tissue.radius * 1e3, depth * 1e3, haptic.largest, pressed, rest, jump, haptic.steepest);
  EXPECT_GT(haptic.largest, 0.01) << "N";
  EXPECT_LT(pressed, 0.05 * haptic.largest);
  EXPECT_LT(rest, 1e-3 * haptic.largest);
  EXPECT_LT(jump, 0.05 * haptic.largest);
  EXPECT_LT(haptic.touch.largest_jump, 0.3 * haptic.largest) << "while it leaves ten times as fast";
  EXPECT_LT(haptic.steepest, 0.1 * haptic.largest) << "likewise";
  EXPECT_GE(haptic.least_push, 0) << "no adhesion";
  EXPECT_LE(haptic.most_rubbing, tissue.friction * (1 + 1e-9));
  EXPECT_EQ(haptic.touch.force, Vec3d{}) << "away";
  EXPECT_EQ(haptic.allocations, 0u);
}

TEST(LocalContact, a_slow_press_on_a_lattice_is_felt_as_its_frames_solve_it) {
  expect_slow_press_like_its_frames({.size = {21, 21, 11}, .step = 0.004, .radius = 0.012}, {0, 0, -1},
                                    0.004);
  expect_slow_press_like_its_frames({.size = {15, 17, 13}, .step = 0.006, .radius = 0.02, .friction = 0.2},
                                    normalized(Vec3d{0.3, 0.1, -1}), 0.0045);
}

/// Pressed in obliquely, 3 mm: what was felt at the end of every frame, in the lattice's axes.
std::vector<Vec3d> felt_in_lattice(const Mat3d& axes, Vec3d origin) {
  Tissue tissue{.size = {15, 15, 9}, .step = 0.004, .radius = 0.012, .axes = axes, .origin = origin};
  const Vec3d middle = tissue.build(), inwards = axes * normalized(Vec3d{0.4, -0.2, -1});
  const Way way = press(middle + axes * Vec3d{0, 0, tissue.radius}, inwards, 0.003, 0.01);
  tissue.begin(way(0));
  Felt haptic;
  haptic.go(way, 0, 0.6, [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); });
  EXPECT_LT(norm(haptic.touch.contact.force - tissue.forces[0].force), 1e-9) << "as the frame summed it";
  std::vector<Vec3d> all;
  for (const Vec3d force : haptic.by_tick) all.push_back(transposed(axes) * force);
  return all;
}

TEST(LocalContact, a_lattice_that_lies_turned_in_the_patient_is_felt_the_same) {
  const Mat3d turned{{{0, 0.8, 0.6}, {0, -0.6, 0.8}, {1, 0, 0}}};
  const std::vector<Vec3d> straight = felt_in_lattice({}, {}),
                           other = felt_in_lattice(turned, {0.3, -0.2, 0.7});
  ASSERT_EQ(straight.size(), other.size());
  double largest = 0;
  for (std::size_t n = 0; n < straight.size(); n++) {
    largest = std::max(largest, norm(straight[n]));
    EXPECT_LT(norm(straight[n] - other[n]), 0.01 * largest + 1e-5) << n << ": a CT's axes change no force";
  }
  EXPECT_GT(largest, 0.01) << "N";
}

TEST(LocalContact, a_ball_that_is_dragged_rubs_no_more_than_coulomb_allows) {
  Tissue tissue{.size = {31, 21, 11}, .step = 0.004, .radius = 0.012, .friction = 0.3};
  const Vec3d middle = tissue.build();
  const Way way = [&](double time) {
    const double depth = 0.003 * std::min(1.0, time / 0.5), along = 0.03 * std::max(0.0, time - 0.6);
    return middle + Vec3d{along - 0.02, 0, tissue.radius - depth};
  };
  tissue.begin(way(0));
  Felt haptic;
  haptic.go(way, 0, 1.8, [&](const Pose& pose) { return tissue.frame(pose, haptic.memory); });
  std::printf("dragged: %.3f of the push, %.5f N a tick of %.4f N\n", haptic.most_rubbing, haptic.steepest,
              haptic.largest);
  EXPECT_LE(haptic.most_rubbing, 0.3 * (1 + 1e-9));
  EXPECT_GT(haptic.most_rubbing, 0.25) << "it slides";
  EXPECT_LT(haptic.steepest, 0.05 * haptic.largest);
}

TEST(LocalContact, between_two_frames_the_force_follows_the_plane_s_stiffness) {
  const LocalContact plane{.is_near = true,
                           .normal = {0, 0, 1},
                           .force = {0, 0, 0.5},
                           .stiffness = 200,
                           .shear_stiffness = 100,
                           .friction = 0.4,
                           .reach = 0.01};
  LocalTouch touch{.params = {.damping = 0}};
  take(touch, plane);
  ToolReading reading;
  const auto at = [&](Vec3d place) {
    tick(touch, {.pose = {place, {}}}, kTick, reading);
    return reading.force;
  };
  EXPECT_LT(norm(at({0, 0, 0}) - Vec3d{0, 0, 0.5}), 1e-12);
  EXPECT_LT(norm(at({0, 0, -0.001}) - Vec3d{0, 0, 0.7}), 1e-12);
  EXPECT_LT(norm(at({0.001, 0, 0}) - Vec3d{-0.1, 0, 0.5}), 1e-12) << "it sticks";
  EXPECT_LT(norm(at({0.005, 0, 0}) - Vec3d{-0.2, 0, 0.5}), 1e-12) << "it slides";
  EXPECT_LT(norm(at({0.004, 0, 0}) - Vec3d{-0.1, 0, 0.5}), 1e-12) << "and sticks again where it slid to";
  EXPECT_EQ(at({0, 0, 0.0026}), Vec3d{}) << "off the plane";
  EXPECT_LT(norm(at({0, 0, -0.05}) - Vec3d{0, 0, 2.5}), 1e-12) << "no farther than the plane is known";
  EXPECT_TRUE(reading.beyond_patch);
  EXPECT_EQ(at({NAN, 0, 0}), Vec3d{});
}

TEST(LocalContact, a_new_plane_comes_in_without_a_step_and_leaves_with_the_contact) {
  LocalContact plane{.is_near = true, .force = {0, 0, 0.5}, .stiffness = 200, .reach = 0.01};
  LocalTouch touch{.params = {.blend_time = 0.02, .largest_step = 0.005}};
  ToolReading reading;
  take(touch, plane);
  for (int i = 0; i < 10; i++) tick(touch, {}, kTick, reading);
  plane.force = {0, 0, 0.3};
  take(touch, plane);
  EXPECT_NEAR(touch.largest_jump, 0.2, 1e-12);
  double before = reading.force.z;
  for (int i = 0; i < 200; i++) {
    tick(touch, {}, kTick, reading);
    EXPECT_LE(before - reading.force.z, 0.005 + 1e-12) << i;
    before = reading.force.z;
  }
  EXPECT_NEAR(before, 0.3, 1e-4);
  plane.force = {0, 0, 0.6};
  take(touch, plane);
  tick(touch, {.pose = {{0, 0, 0.004}, {}}}, kTick, reading);
  EXPECT_EQ(reading.force, Vec3d{}) << "what is left of a jump does not hold on to a tool that has left";
}

/// A sheet that is held along all its edges, with a ball over its middle.
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
  LocalContact frame(const Pose& to, LocalMemory& memory) {
    cloth::Inputs inputs = cloth::in_vacuum(0);
    inputs.obstacles.push_back(cloth_obstacle(ball, at, to, kFrame));
    inputs.obstacles[0].friction = 0.3;
    EXPECT_TRUE(cloth::step(Exec(2), model, state, inputs, kFrame).finite);
    at = to;
    return local_contact(model, state, 0, inputs.obstacles[0].gap, {ball, 0.3}, to, kFrame, memory);
  }
};

TEST(LocalContact, a_taut_sheet_bears_a_tool_by_tick_as_it_does_by_frame) {
  for (Sheet sheet :
       {Sheet{.n = 25, .spacing = 0.01}, Sheet{.n = 17, .spacing = 0.02, .ball = Sphere{0.05}}}) {
    sheet.begin();
    const double radius = bounding_radius(sheet.ball), middle = 0.5 * (sheet.n - 1) * sheet.spacing;
    const Way way = press({middle, middle, radius + 0.002}, {0, 0, -1}, 0.02, 0.04);
    sheet.at = {way(0), {}};
    Felt haptic;
    const auto frame = [&](const Pose& pose) { return sheet.frame(pose, haptic.memory); };
    haptic.go(way, 0, 1.3, frame);
    const double rest = norm(haptic.by_tick.back() - haptic.by_frame.back());
    std::printf("sheet: %.4f N, between frames off by %.4f N, at rest by %.1e N; %.5f N a tick\n",
                haptic.largest, haptic.worst(), rest, haptic.steepest);
    EXPECT_GT(haptic.by_frame.back().z, 0.01) << "N: the sheet bears the ball";
    EXPECT_LT(rest, 0.02 * haptic.largest);
    EXPECT_LT(haptic.worst(), 0.25 * haptic.largest) << "while it swings";
    haptic.go(way, 1.3, 2.2, frame);
    EXPECT_GE(haptic.least_push, 0);
    EXPECT_LE(haptic.most_rubbing, 0.3 * (1 + 1e-9));
    EXPECT_EQ(haptic.touch.force, Vec3d{}) << "N: away";
    EXPECT_EQ(haptic.allocations, 0u);
  }
}

}  // namespace
}  // namespace turgor::contact
