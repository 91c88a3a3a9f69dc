// A sewn wound returns no more energy than it was given.
#include <algorithm>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/suture/half_bodies.hpp"
#include "turgor/models/lattice/solver/energy.hpp"

namespace turgor::lattice {
namespace {

/// A bar of half bodies without damping at rest, sewn or open, and its budget of energy.
struct RestingBar {
  static constexpr double kMuch = 20;  // damping until it rests [1/s]
  HalfBodies body{{17, 9, 6}, 38, kMuch};
  WoundClosure closure;
  double time = 0;  // [s]

  explicit RestingBar(bool is_sewn) {
    if (is_sewn) closure = body.stitched(0.016);
    sew(Exec(1), body.model, body.state, kPull, 240, time, closure);
    EXPECT_TRUE(closure.settled);
    EXPECT_LT(kinetic_energy(body.model, body.state.motion), 1e-12) << "J: at rest";
    body.model.params.solver.damping = 0;
  }
  /// Nodes of the left half near the wound; `on_skin`: only those of the top layer.
  std::vector<int> pushed(bool on_skin) const {
    std::vector<int> slots;
    for (int s = 0; s < int(body.state.motion.u.x.size()); s++) {
      if (!has_node(body.model, s) || !(body.model.anatomy.inverse_mass[std::size_t(s)] > 0)) continue;
      const Int3 p = slot_node(body.model.anatomy.lattice, s);
      if (p.x >= 5 && p.x <= 8 && (!on_skin || p.z == 5)) slots.push_back(s);
    }
    return slots;
  }
  double energy() const {
    return lattice::energy(Exec(1), body.model, body.state) + kinetic_energy(body.model, body.state.motion) +
           stored_energy(body.model, body.state.motion, closure);
  }
  void step(std::span<const NodeLoad> loads) {
    PointSprings springs;
    append_springs(closure, springs.all);
    make_terms(springs);
    springs.refresh = [&](const State& now) { update_springs(body.model, now.motion, closure, springs.all); };
    Inputs inputs{.springs = &springs};
    inputs.loads = loads;
    ASSERT_TRUE(lattice::step(Exec(1), body.model, body.state, inputs, HalfBodies::kFrameTime).finite);
    update_multipliers(body.model, body.state.motion, closure);
  }

  static constexpr Pull kPull{.duration = 0.4};
};

constexpr Vec3d kPushes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};

// Forces push beside a wound for some frames and let go. At no time has the body more energy than the forces
// gave it: motion, tissue and skin, threads, and the contact of walls and rims. There is no damping.
TEST(PassiveClosure, PushReturnsNoMoreThanItsWork) {
  for (const bool is_sewn : {false, true}) {
    const RestingBar rest(is_sewn);
    const std::vector<int> pushed = rest.pushed(true);
    double most = 0, least = 0;
    for (const Vec3d push : kPushes)
      for (const double newtons : {0.02, 0.5})
        for (const int frames : {1, 4}) {
          RestingBar bar = rest;
          std::vector<NodeLoad> loads;
          for (const int slot : pushed)
            loads.push_back({slot, Vec3(push * (newtons / double(pushed.size())))});
          const double before = bar.energy();
          double work = 0, given = 0, above = 0, below = 0;
          for (int n = 0; n < frames + 10; n++) {
            if (n == frames) loads.clear();
            const VecField u = bar.body.state.motion.u;
            bar.step(loads);
            for (const NodeLoad& load : loads) {
              const auto s = std::size_t(load.slot);
              work += dot(Vec3d(load.force), Vec3d(bar.body.state.motion.u[s]) - Vec3d(u[s]));
            }
            given = std::max(given, work);
            const double gained = bar.energy() - before;
            above = std::max(above, gained - work), below = std::min(below, gained);
          }
          EXPECT_LE(above, 0.01 * given) << "J: push of " << newtons << " N";
          EXPECT_GE(below, -0.01 * given) << "J: the wound held no energy that a push releases";
          most = std::max(most, above / given), least = std::min(least, below / given);
        }
    std::printf("%s: at most %.1e of the push's work above it, %.1e below the energy at rest\n",
                is_sewn ? "sewn" : "open", most, -least);
  }
}

// A blow gives the nodes beside a sewn wound a velocity that their neighbors lack, slow or fast. The energy
// falls from step to step, and never exceeds that of the blow.
TEST(PassiveClosure, BlowLosesEnergyInEveryStep) {
  const RestingBar rest(true);
  const std::vector<int> pushed = rest.pushed(false);
  double most = 0;
  for (const Vec3d push : kPushes)
    for (const double speed : {0.01, 0.1, 1.0}) {
      RestingBar bar = rest;
      const double before = bar.energy();
      for (const int slot : pushed) bar.body.state.motion.v.set(std::size_t(slot), Vec3(push * speed));
      bar.body.state.motion.fastest = Real(speed);
      const double given = bar.energy() - before;
      double last = given;
      for (int n = 0; n < 10; n++) {
        bar.step({});
        const double left = bar.energy() - before;
        EXPECT_LE(left, last + 0.001 * given) << "J: step " << n << " after a blow of " << speed << " m/s";
        last = left;
        most = std::max(most, left / given);
      }
    }
  std::printf("at most %.2f of the blow's energy is left after a step\n", most);
}

}  // namespace
}  // namespace turgor::lattice
