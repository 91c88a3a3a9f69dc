// Needles by hand: pushed along the normal of their entry by dragging, wheel or keys, and withdrawn.
#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kOutside = -0.004;  // depth of a tip that does not touch [m]
constexpr double kFastest = 0.03;    // speed of the needle [m/s]

NeedleUse* needle_of(Viewer& viewer) {
  return viewer.touching && viewer.touching->needle ? &*viewer.touching->needle : nullptr;
}

void set_goal(Viewer& viewer, double depth) {
  NeedleUse& needle = *needle_of(viewer);
  needle.goal = std::clamp(depth, kOutside, needle.length);
}

}  // namespace

std::optional<double> needle_length(const Scene& scene, int tool) {
  if (tool < 0 || std::size_t(tool) >= scene.tools.size()) return std::nullopt;
  const auto* needle = std::get_if<NeedleTool>(&scene.tools[std::size_t(tool)].shape);
  return needle ? std::optional(needle->needle.length) : std::nullopt;
}

void hold_needle(Viewer& viewer) {
  Touching& touching = *viewer.touching;
  if (!touching.needle) return;
  NeedleUse& needle = *touching.needle;
  if (needle.moved == Clock::time_point())
    touching.depth = needle.goal = kOutside, needle.moved = Clock::now();
  needle.is_held = true, needle.leaves = false;
  needle.cursor = viewer.cursor.y, needle.pressed_depth = needle.goal;
}

bool push_needle(Viewer& viewer, double depth) {
  NeedleUse* needle = needle_of(viewer);
  if (!needle) return false;
  set_goal(viewer, needle->goal + depth);
  needle->leaves = false;
  needle->cursor = viewer.cursor.y, needle->pressed_depth = needle->goal;
  return true;
}

void drag_needle(Viewer& viewer) {
  constexpr double kDepth = 0.05;  // over half the picture [m]
  const NeedleUse& needle = *needle_of(viewer);
  set_goal(viewer, needle.pressed_depth + kDepth * (needle.cursor - viewer.cursor.y));
}

void move_needle(Viewer& viewer) {
  NeedleUse* needle = needle_of(viewer);
  if (!needle) return;
  // a paused world does not move
  const auto now = Clock::now();
  const double pace = viewer.now->plays ? std::min(1.0, viewer.now->pace) : 0;
  const double most = kFastest * pace * std::chrono::duration<double>(now - needle->moved).count();
  needle->moved = now;
  double& depth = viewer.touching->depth;
  depth += std::clamp(needle->goal - depth, -most, most);
  if (!needle->leaves || depth > kOutside) return;
  viewer.touched = viewer.touching->position;
  viewer.touching->needle.reset();
  end_press(viewer);
}

void withdraw_needle(Viewer& viewer) {
  NeedleUse* needle = needle_of(viewer);
  if (!needle) return;
  needle->goal = kOutside, needle->leaves = true, needle->is_held = false;
  viewer.message = "the needle is withdrawn";
}

}  // namespace turgor
