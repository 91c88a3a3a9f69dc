// A half space under one or several tools, tick by tick.
#pragma once

#include <cmath>
#include <vector>

#include "tests/contact/half_space.hpp"
#include "turgor/contact/touch.hpp"

namespace turgor::contact {

constexpr double kTick = 1e-3;
constexpr double kRadius = 5e-3;

/// One tool over a half space.
struct Touched {
  sfem::Patch patch;
  std::vector<Tool> tools;
  TouchState state;
  std::vector<ToolForce> forces;

  Touched(const HalfSpace& half_space, std::vector<Tool> with, const TouchParams& params = {})
      : patch(half_space_patch(half_space)),
        tools(std::move(with)),
        state(make_touch_state(patch, tools.size(), params)),
        forces(tools.size()) {}

  ToolForce press(Vec3d at, bool hold = false) {
    const std::vector<ToolPose> poses{{{at, {}}, hold}};
    solve_touch_tick(patch, state, tools, poses, kTick, forces);
    return forces[0];
  }
  ToolForce settle(Vec3d at, int ticks = 20, bool hold = false) {
    for (int i = 1; i < ticks; i++) press(at, hold);
    return press(at, hold);
  }
  /// Moves along a line in steps of at most 10 µm. Returns the largest change of force between two steps.
  double move(Vec3d from, Vec3d to, bool hold = false) {
    const int steps = std::max(1, int(std::ceil(norm(to - from) / 1e-5)));
    Vec3d before = forces[0].force;
    double jump = 0;
    for (int i = 1; i <= steps; i++) {
      const Vec3d now = press(from + (to - from) * (double(i) / steps), hold).force;
      jump = std::max(jump, norm(now - before));
      before = now;
    }
    return jump;
  }
};

inline Vec3d above(double x, double y, double depth) { return {x, y, kRadius - depth}; }

}  // namespace turgor::contact
