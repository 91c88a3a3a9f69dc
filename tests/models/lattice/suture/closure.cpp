// Stitches close a wound with the forces that mechanics demands.
#include "turgor/models/lattice/suture/closure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/suture/half_bodies.hpp"
#include "turgor/models/lattice/solver/energy.hpp"

namespace turgor::lattice {
namespace {

constexpr double kFrameTime = HalfBodies::kFrameTime, kCell = HalfBodies::kCell;

/// Force of skin and tissue through the section between node columns i and i + 1, by a difference of energies
/// without the prestress [N].
double section_force(const Model& model, const State& state, int column) {
  constexpr double kShift = 1e-4;
  double energies[2];
  for (const int side : {0, 1}) {
    State moved = state;
    for (std::size_t s = 0; s < model.anatomy.tissue.size(); s++) {
      if (!has_node(model, int(s)) || slot_node(model.anatomy.lattice, int(s)).x > column) continue;
      moved.motion.u.x[s] += Real(side ? kShift : -kShift);
    }
    energies[side] = energy(Exec(1), model, moved);
  }
  double prestress = 0;
  for (std::size_t n = 0; n < model.prestress_force.size(); n++)
    if (slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[n]).x <= column)
      prestress += double(model.prestress_force[n].x);
  return prestress - (energies[1] - energies[0]) / (2 * kShift);
}

// Two half bodies pulled together: the lips meet, every thread follows its law, and the closing force is the
// integral of the tension over a section of the body.
TEST(Closure, HalfBodiesCarryTension) {
  HalfBodies body({27, 9, 6}, 38);
  double time = 0;
  for (int n = 0; n < 30; n++) step(Exec(1), body.model, body.state, {}, kFrameTime);
  const double open = measure_wound(body.model, body.state, body.path, 0).gape_max;
  WoundClosure closure = body.stitched(0.008);
  ASSERT_EQ(closure.stitches.size(), 4u);
  sew(Exec(1), body.model, body.state, {.duration = 0.4}, 130, time, closure);
  Vec3d sum, moment;
  double most = 0;
  for (const Stitch& stitch : closure.stitches) {
    const double k = closure.thread.stiffness / stitch.length,
                 law = k * (loop_length(stitch, body.state.motion) - stitch.length);
    EXPECT_EQ(stitch.phase, StitchPhase::kKnotted);
    EXPECT_NEAR(stitch.tension, law, 1e-3 * law) << "N";
    EXPECT_LT(gape_under(stitch, body.state.motion), 3e-4) << "m";
    const std::vector<Vec3d> forces = stitch_forces(stitch, body.state.motion);
    for (std::size_t p = 0; p < forces.size(); p++) {
      sum += forces[p];
      moment += cross(stitch.rest[p] + Vec3d(displacement(stitch.at[p], body.state.motion)), forces[p]);
      most = std::max(most, norm(forces[p]));
    }
  }
  EXPECT_LT(norm(sum), 1e-9 * most);
  EXPECT_LT(norm(moment), 1e-9 * most);
  const double closing = closing_force(closure, body.state.motion),
               section = section_force(body.model, body.state, 6), ct = 38 * 8 * kCell;
  std::printf("gape %.2f mm open; closing force %.4f N, section %.4f N, skin of the CT %.4f N\n", 1e3 * open,
              closing, section, ct);
  EXPECT_GT(open, 5e-3) << "m";
  EXPECT_NEAR(closing, section, 0.01 * section) << "N";
  // the free rim of the skin between lip and stitch retracts, so that the rest is stretched more
  EXPECT_GT(closing, ct) << "N";
  EXPECT_LT(closing, 1.3 * ct) << "N";
}

/// Kinetic and elastic energy of a body, its threads and the contact of its lips [J].
double total_energy(const HalfBodies& body, const WoundClosure& closure) {
  return energy(Exec(1), body.model, body.state) + kinetic_energy(body.model, body.state.motion) +
         stored_energy(body.model, body.state.motion, closure);
}

// The energy that a body gains while its stitches are pulled is the hand's work, tension times thread, and at
// most 3 % more. Threads that are pulled fast lag behind their law.
TEST(Closure, HandDoesTheWorkOfClosing) {
  for (const double duration : {0.4, 1.2}) {
    HalfBodies body({17, 9, 6}, 38);
    double time = 0;
    WoundClosure closure;
    sew(Exec(1), body.model, body.state, {}, 60, time, closure);
    closure = body.stitched(0.016);
    const Pull pull{.start = time, .duration = duration};
    const double open = total_energy(body, closure);
    double work = 0;
    for (int n = 0; n < duration / kFrameTime + 40; n++) {
      const std::vector<Stitch> before = closure.stitches;
      sew(Exec(1), body.model, body.state, pull, 1, time, closure);
      for (std::size_t i = 0; i < before.size(); i++) {
        const Stitch& now = closure.stitches[i];
        const double length = before[i].length > 0 ? before[i].length : now.before;
        work += 0.5 * (before[i].tension + now.tension) * (length - now.length);
      }
    }
    for (const Stitch& stitch : closure.stitches) EXPECT_EQ(stitch.phase, StitchPhase::kKnotted);
    const double gained = total_energy(body, closure) - open;
    std::printf("pulled for %.1f s: work of the hand %.3f mJ, gained %.3f mJ\n", duration, 1e3 * work,
                1e3 * gained);
    EXPECT_LE(gained, 1.03 * work);
    EXPECT_GE(gained, 0.95 * work);
  }
}

// A stitch tears out of the tissue, or its thread breaks, at the stated force.
TEST(Closure, StitchesEndAtTheirStrength) {
  for (const bool thread_is_weak : {false, true}) {
    HalfBodies body({17, 7, 5}, 30);
    WoundClosure closure = body.stitched(0.025);
    ASSERT_EQ(closure.stitches.size(), 1u);
    constexpr double kPull = 0.6, kSeconds = 1, kWeak = 0.31;
    (thread_is_weak ? closure.thread.strength : closure.pull_out) = kWeak;
    const Pull pull{.until_closed = false, .tension = kPull, .duration = kSeconds};
    double time = 0, before = 0;
    while (bears(closure.stitches[0].phase) || time == 0) {
      ASSERT_LT(time, kSeconds);
      before = closure.stitches[0].tension;
      sew(Exec(1), body.model, body.state, pull, 1, time, closure);
    }
    EXPECT_EQ(closure.stitches[0].phase, thread_is_weak ? StitchPhase::kBroken : StitchPhase::kPulledOut);
    // two strands at about a right angle act on a point of the tissue
    const double step = kPull * kFrameTime / kSeconds, force = thread_is_weak ? 1 : std::sqrt(2.0);
    EXPECT_LE(before, kWeak) << "N";
    EXPECT_NEAR((before + step) * force, kWeak, thread_is_weak ? step : 0.2 * kWeak) << "N";
    EXPECT_EQ(closing_force(closure, body.state.motion), 0);
  }
}

// In a running suture the pulled end draws thread through all stitches, whose tensions differ by the capstan
// equation [Euler–Eytelwein]. Nothing is lost of the thread.
TEST(Closure, RunningThreadFollowsCapstanEquation) {
  const HalfBodies body({17, 13, 6}, 0);
  WoundClosure closure =
      lay_stitches(body.model, body.state.cuts, body.path, {.spacing = 0.011, .is_running = true}).value();
  closure.thread = {.stiffness = 100, .strength = 50, .friction = 0.03}, closure.pull_out = 50;
  ASSERT_EQ(closure.stitches.size(), 4u);
  // the tissue is held; the thread of the last stitch is too short
  for (Stitch& stitch : closure.stitches)
    stitch.phase = StitchPhase::kKnotted, stitch.length = loop_length(stitch, body.state.motion) * 1.002;
  closure.stitches.back().length *= 0.95;
  const double thread = thread_length(closure);
  PointSprings springs;
  append_springs(closure, springs.all);
  for (int n = 0; n < 3000 && !(n > 10 && closure.settled); n++) {
    update_springs(body.model, body.state.motion, closure, springs.all);
    update_multipliers(body.model, body.state.motion, closure);
  }
  EXPECT_NEAR(thread_length(closure), thread, 1e-12 * thread);
  Vec3d sum;
  for (std::size_t n = 0; n < closure.stitches.size(); n++) {
    for (const Vec3d f : stitch_forces(closure.stitches[n], body.state.motion)) sum += f;
    if (n == 0) continue;
    // four right angles between two deep strands: up, across the skin, down, and below the wound
    const double tension = closure.stitches[n].tension, before = closure.stitches[n - 1].tension,
                 capstan = std::exp(closure.thread.friction * 2 * std::numbers::pi);
    std::printf("tensions %.3f and %.3f N, ratio %.4f, capstan equation %.4f\n", before, tension,
                tension / before, capstan);
    EXPECT_NEAR(tension / before, capstan, 0.01 * capstan);
  }
  EXPECT_LT(norm(sum), 1e-9);
}

// A pull that is over before its first step knots closed stitches with the thread of their loops: the thread
// of a running suture slides with finite tensions. A second pull keeps the tension.
TEST(Closure, PullShorterThanStepGivesThread) {
  const HalfBodies body({17, 13, 6}, 0);
  const State uncut = make_state(body.model);
  for (const bool is_running : {false, true}) {
    WoundClosure closure =
        lay_stitches(body.model, uncut.cuts, body.path, {.spacing = 0.011, .is_running = is_running}).value();
    closure.thread = {.stiffness = 100, .strength = 50, .friction = 0.03}, closure.pull_out = 50;
    const Pull pull{.start = 0.1, .duration = 1e-3};
    pull_stitches(uncut.motion, pull, 0.11, closure);
    PointSprings springs;
    append_springs(closure, springs.all);
    for (int n = 0; n < 20; n++) {
      update_springs(body.model, uncut.motion, closure, springs.all);
      update_multipliers(body.model, uncut.motion, closure);
    }
    for (const Stitch& stitch : closure.stitches) {
      EXPECT_EQ(stitch.phase, StitchPhase::kKnotted);
      EXPECT_NEAR(stitch.length, loop_length(stitch, uncut.motion), 1e-9);
      EXPECT_NEAR(stitch.tension, 0, 1e-6);
    }
    // again, under tension
    constexpr double kTension = 0.5;
    for (Stitch& stitch : closure.stitches) stitch.tension = kTension;
    untie_stitches(uncut.motion, closure);
    pull_stitches(uncut.motion, pull, 0.11, closure);
    for (const Stitch& stitch : closure.stitches)
      EXPECT_NEAR(closure.thread.stiffness * (loop_length(stitch, uncut.motion) / stitch.length - 1),
                  kTension, 1e-9);
  }
}

// The state and the forces do not depend on the number of threads.
TEST(Closure, SameBitsOnAnyThreads) {
  double tension[3];
  std::uint64_t hash[3];
  for (const int run : {0, 1, 2}) {
    HalfBodies body({17, 9, 6}, 38);
    WoundClosure closure = body.stitched(0.016);
    double time = 0;
    sew(Exec(run == 0 ? 1 : run == 1 ? 2 : 8), body.model, body.state, {.duration = 0.2}, 12, time, closure);
    tension[run] = closure.stitches[0].tension;
    hash[run] = state_hash(body.model, body.state);
  }
  EXPECT_EQ(tension[0], tension[1]);
  EXPECT_EQ(tension[0], tension[2]);
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_EQ(hash[0], hash[2]);
}

// A stitch through air is refused with the position.
TEST(Closure, StitchThroughAirIsRefused) {
  const HalfBodies body({17, 7, 5}, 30);
  const auto refused = lay_stitches(
      body.model, body.state.cuts, body.path,
      {.through = {{{0.02, 0.01, 0.01}, {0.04, 0.01, 0.01}}, {{0.02, 0.01, 0.03}, {0.04, 0.01, 0.01}}}});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("through air at [0.02, 0.01, 0.03] m"), std::string::npos)
      << refused.error().message;
}

}  // namespace
}  // namespace turgor::lattice
