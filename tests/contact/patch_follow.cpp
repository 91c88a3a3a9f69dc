#include "turgor/contact/patch_follow.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/contact/half_space.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kRadius = 5e-3, kTick = 1e-3;
const HalfSpace kSpace{.side = 15};
const std::vector<Tool> kBall{{Sphere{kRadius}, 0.4}};

struct PatchScene {
  sfem::Patch patch = half_space_patch(kSpace);
  TouchState state;
  std::vector<ToolForce> forces{1};

  explicit PatchScene(const TouchParams& params = {.capacity = 64})
      : state(make_touch_state(patch, 1, params)) {}
  ToolForce press(Vec3d at, bool hold = false) {
    const std::vector<ToolPose> poses{{{at, {}}, hold}};
    solve_touch_tick(patch, state, kBall, poses, kTick, forces);
    return forces[0];
  }
  void settle(Vec3d at) {
    for (int i = 0; i < 30; i++) press(at);
  }
  Handover take(sfem::Patch next) {
    TransferredHistory history;
    for (int pair = 0; pair < state.history.count; pair++)
      history.pairs.push_back(
          {std::vector<Vec3d>(next.points.size()), coarse_history(state.history, pair, patch)});
    const Handover handover = take_patch(state, patch, next, kBall, history);
    patch = std::move(next);
    return handover;
  }
};

std::vector<Vec3d> touched_positions_of(const sfem::Model& model, const sfem::Patch& patch,
                                        const TouchState& state, std::span<const ToolPose> poses,
                                        std::span<const Vec3d> before = {}) {
  std::vector<ContactCenter> contact_centers(poses.size());
  find_contact_centers(patch, state, contact_centers);
  return touched_positions(model, contact_centers, poses, before);
}

Vec3d at(double x, double depth) { return {x, 0, kRadius - depth}; }

// A handover to the same patch keeps the force.
TEST(PatchFollow, SamePatchKeepsForce) {
  PatchScene m;
  for (int i = 0; i < 100; i++) m.press(at(1e-5 * i, 1e-3));
  m.settle(at(99e-5, 1e-3));
  const Vec3d before = m.forces[0].force;
  const Handover handover = m.take(m.patch);
  EXPECT_EQ(handover.shared_points, 15 * 15);
  EXPECT_LT(handover.force_jump, 1e-5 * norm(before));
  EXPECT_LT(norm(m.press(at(99e-5, 1e-3)).force - before), 1e-5 * norm(before));
}

// A handover to a shifted patch of the same half space keeps the force, friction included.
TEST(PatchFollow, ShiftedPatchKeepsForce) {
  PatchScene m;
  for (int i = 0; i < 200; i++) m.press(at(1e-5 * i, 1e-3));
  m.settle(at(199e-5, 1e-3));
  const Vec3d before = m.forces[0].force;
  EXPECT_GT(std::abs(before.x), 0.1 * before.z) << "with friction";
  const Handover handover = m.take(half_space_patch(kSpace, {2e-3, 0, 0}));
  EXPECT_EQ(handover.shared_points, 13 * 15);
  EXPECT_LT(handover.force_jump, 1e-5 * norm(before));
}

// A patch with other points makes the force jump; the jump is blended over ticks.
TEST(PatchFollow, JumpIsBlendedOverTicks) {
  const FollowParams params{.blend_time = 0.02, .largest_step = 1e-4};
  PatchScene m;
  for (int i = 0; i < 100; i++) m.press(at(0, 1e-3));
  const Vec3d before = m.forces[0].force;
  const Handover handover = m.take(half_space_patch({.side = 21, .spacing = 0.7e-3}, {0.2e-3, 0, 0}));
  EXPECT_LT(handover.shared_points, 15 * 15);
  EXPECT_GT(handover.force_jump, 1e-4);
  EXPECT_LT(handover.force_jump, 0.3 * norm(before));
  Vec3d last = before;
  double largest = 0;
  for (int i = 0; i < 400; i++) {
    m.press(at(0, 1e-3));
    const Vec3d raw = m.forces[0].force;
    blend(params, m.state, kTick, m.forces);
    largest = std::max(largest, norm(m.forces[0].force - last));
    last = m.forces[0].force;
    if (i < 399) continue;
    EXPECT_LT(norm(last - raw), 1e-3 * handover.force_jump);
  }
  EXPECT_LT(largest, 1.01 * std::min(params.largest_step, handover.force_jump * kTick / params.blend_time) +
                         1e-4 * norm(before));
  std::printf("jump %.5f N of %.5f N, blended to at most %.6f N per tick\n", handover.force_jump,
              norm(before), largest);
}

// The rest of a jump vanishes when the contact ends.
TEST(PatchFollow, BlendEndsWithContact) {
  PatchScene m;
  for (int i = 0; i < 20; i++) m.press(at(0, 1e-3));
  m.take(half_space_patch({.side = 21, .spacing = 0.7e-3}));
  m.press(at(0, -1e-3));
  blend({.blend_time = 10, .largest_step = 1e-9}, m.state, kTick, m.forces);
  EXPECT_EQ(m.forces[0].force, Vec3d{});
}

// Held points stay held at their positions after a handover.
TEST(PatchFollow, HeldPointsStayHeld) {
  PatchScene m;
  for (int i = 0; i < 20; i++) m.press(at(0, 0.5e-3));
  for (int i = 0; i <= 50; i++) m.press(at(1e-5 * i, 0.5e-3), true);
  const Vec3d before = m.forces[0].force;
  const Handover handover = m.take(half_space_patch(kSpace, {2e-3, 0, 0}));
  EXPECT_LT(handover.force_jump, 1e-9 * norm(before));
  EXPECT_GT(m.state.held, 0);
}

// The patch follows only after the contact center has moved by the hysteresis.
TEST(PatchFollow, MustFollow_HasHysteresis) {
  const FollowParams params{.radius = 0.02, .hysteresis = 0.5};
  const std::vector<Vec3d> center{{0, 0, 0}}, near{{9e-3, 0, 0}}, far{{11e-3, 0, 0}};
  EXPECT_FALSE(must_follow(params, center, near));
  EXPECT_TRUE(must_follow(params, center, far));
  EXPECT_TRUE(must_follow(params, {}, near)) << "no patch yet";
}

// The touched position is the center of the contacts; without contacts it is the nearest surface point.
TEST(PatchFollow, TouchedPositionIsContactCenter) {
  PatchScene m;
  for (int i = 0; i < 20; i++) m.press(at(2e-3, 0.5e-3));
  sfem::Model model;
  model.body.mesh.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  model.surface.triangles = {{0, 1, 2}};
  const std::vector<ToolPose> touching{{{at(2e-3, 0.5e-3), {}}, false}};
  EXPECT_LT(norm(touched_positions_of(model, m.patch, m.state, touching)[0] - Vec3d{2e-3, 0, 0}), 0.2e-3);
  m.press({0.03, 0.02, 0.05});
  const std::vector<ToolPose> away{{{{0.03, 0.02, 0.05}, {}}, false}};
  EXPECT_LT(norm(touched_positions_of(model, m.patch, m.state, away)[0] - Vec3d{0.03, 0.02, 0}), 1e-12);
  const std::vector<ToolPose> bad{{{{NAN, 0, 0}, {}}, false}};
  const std::vector<Vec3d> before{{1, 2, 3}};
  EXPECT_EQ(touched_positions_of(model, m.patch, m.state, bad, before)[0], before[0]);
}

// A handover keeps the force and the history of a viscous material.
TEST(PatchFollow, HandoverKeepsViscousHistory) {
  PatchScene m({.capacity = 64, .viscosity = {{{{0.6, 0.2}, {0.4, 2}, {}}}}});
  for (int i = 0; i < 100; i++) m.press(at(0, 1e-5 * i));
  m.settle(at(0, 1e-3));
  const Vec3d before = m.forces[0].force;
  const Handover handover = m.take(m.patch);
  EXPECT_LT(handover.force_jump, 1e-5 * norm(before));
  for (std::size_t pair = 0; pair < 2; pair++) {
    EXPECT_FALSE(m.state.history.pairs[pair].far.empty());
    Vec3d total;
    for (const VertexForce& f : m.state.history.pairs[pair].far) total += f.force;
    EXPECT_LT(total.z, 0) << "the history has the press";
  }
}

/// A block of soft tissue on a fixed floor, whose patch follows a sliding ball.
struct Block {
  sfem::Model model;
  FollowParams params{.radius = 12e-3, .hysteresis = 0.35, .blend_time = 0.03, .largest_step = 2e-3};
  std::vector<Vec3d> centers{{-15e-3, 0, 0}};
  Prony viscosity;

  explicit Block(const Prony& with) : viscosity(with) {
    sfem::Body body;
    body.mesh = hex_block({60e-3, 40e-3, 20e-3}, {12, 8, 4});
    for (Vec3d& x : body.mesh.vertices) x += Vec3d{-30e-3, -20e-3, -20e-3};
    for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < -19.9e-3);
    body.materials = {{5e3, 0.4}};
    Result<sfem::Model> built = sfem::build(Exec(2), std::move(body), {.touch_depth = 0.02});
    EXPECT_TRUE(built) << built.error().message;
    model = std::move(*built);
    EXPECT_TRUE(sfem::compute_green(Exec(2), model, std::size_t(1) << 30));
  }
  sfem::Patch patch_at(std::span<const Vec3d> positions) const {
    return sfem::build_patch(model, sfem::patch_elements(model, positions, params.radius), 2, positions)
        .value();
  }
};

struct SlideReport {
  int handovers = 0;
  double force = 0, largest_jump = 0, largest_raw_step = 0, largest_blended_step = 0;  // [N]
};

SlideReport slide_over(Block& block) {
  sfem::Patch patch = block.patch_at(block.centers);
  TouchState state =
      make_touch_state(patch, 1, {.capacity = 64, .viscosity = block.viscosity}, 4 * patch.points.size());
  std::vector<ToolForce> forces(1);
  SlideReport report;
  Vec3d raw, blended;
  for (int i = 0; i <= 3300; i++) {  // 300 ticks down, then 30 mm at 10 µm per tick
    const double depth = 2e-3 * std::min(1.0, i / 300.0), x = -15e-3 + 1e-5 * std::max(0, i - 300);
    const std::vector<ToolPose> poses{{{{x, 1e-3, kRadius - depth}, {}}, false}};
    const std::vector<Vec3d> positions =
        touched_positions_of(block.model, patch, state, poses, block.centers);
    if (must_follow(block.params, block.centers, positions)) {
      sfem::Patch next = block.patch_at(positions);
      TransferredHistory history;
      if (pair_count(block.viscosity) > 0)
        history = transferred_history(block.model, state.history, patch, next);
      const Handover handover = take_patch(state, patch, next, kBall, history);
      EXPECT_GT(handover.shared_points, 20);
      report.largest_jump = std::max(report.largest_jump, handover.force_jump);
      report.handovers++;
      patch = std::move(next);
      block.centers = positions;
    }
    solve_touch_tick(patch, state, kBall, poses, kTick, forces);
    if (i > 300) report.largest_raw_step = std::max(report.largest_raw_step, norm(forces[0].force - raw));
    raw = forces[0].force;
    blend(block.params, state, kTick, forces);
    if (i > 300)
      report.largest_blended_step = std::max(report.largest_blended_step, norm(forces[0].force - blended));
    blended = forces[0].force;
    EXPECT_FALSE(forces[0].beyond_patch) << i;
  }
  report.force = norm(blended);
  std::printf(
      "%d hand-overs over 30 mm at %.4f N: largest jump %.5f N; largest step per tick %.5f N, blended %.5f "
      "N\n",
      report.handovers, report.force, report.largest_jump, report.largest_raw_step,
      report.largest_blended_step);
  return report;
}

// The haptic force of a sliding ball stays continuous while the patch is rebuilt.
TEST(PatchFollow, SlidingBallHasContinuousForce) {
  for (const Prony& viscosity : {Prony{}, Prony{{{{0.6, 0.1}, {0.4, 1}, {}}}}}) {
    Block block(viscosity);
    const SlideReport report = slide_over(block);
    EXPECT_GE(report.handovers, 5);
    EXPECT_LT(report.largest_jump, 0.15 * report.force);
    EXPECT_LT(report.largest_blended_step, 0.02 * report.force);
  }
}

}  // namespace
}  // namespace turgor::contact
