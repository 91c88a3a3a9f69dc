// A needle that moves along its axis in a block of finite elements, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "turgor/contact/needle_touch.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact::test_needles {

/// Block whose top is at z = height, with Green's functions between all vertices.
struct NeedleBlock {
  sfem::InnerGreen inner;
  double width = 0, height = 0, young = 4e3, poisson = 0.45;
};

enum class Held { kBottom, kSides };

/// With an axis: only the elements around a vertical line through it.
inline NeedleBlock make_block(double width, double height, double edge, Held held, int threads = 2,
                              std::optional<Vec3d> axis = {}, double young = 4e3) {
  NeedleBlock block{.inner = {}, .width = width, .height = height, .young = young};
  const int across = int(std::lround(width / edge)), down = int(std::lround(height / edge));
  sfem::Body body;
  body.mesh = hex_block({width, width, height}, {across, across, down});
  for (const Vec3d x : body.mesh.vertices) {
    const bool is_side = x.x < 1e-9 || x.y < 1e-9 || x.x > width - 1e-9 || x.y > width - 1e-9;
    body.fixed.push_back(held == Held::kSides ? is_side : x.z < 1e-9);
  }
  body.materials = {{block.young, block.poisson}};
  sfem::Model model =
      *sfem::build(Exec(threads), std::move(body), {.formulation = sfem::Formulation::kAveraged});
  EXPECT_TRUE(sfem::factorize(Exec(threads), model));
  std::vector<int> all;
  for (std::size_t e = 0; e < element_count(model.body.mesh); e++) {
    const Vec3d d = axis ? centroid(model.body.mesh, e) - *axis : Vec3d{};
    if (std::hypot(d.x, d.y) < edge) all.push_back(int(e));
  }
  block.inner = sfem::make_inner_green(Exec(threads), model, all);
  return block;
}

inline const NeedleBlock& soft_block() {
  static const NeedleBlock block = make_block(0.06, 0.05, 0.01, Held::kBottom);
  return block;
}

/// Axes whose z axis is tilted from the vertical toward a direction around it [rad].
inline Mat3d tilted_axes(double tilt, double around) {
  const Vec3d z{std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt)};
  const Vec3d x = normalized(cross(Vec3d{0.3, 1, 0}, z));
  return {{x, cross(z, x), z}};
}

/// A needle that moves along its axis.
struct Insertion {
  const NeedleBlock& block;
  Needle needle;
  Pose pose;
  Vec3d entry;  // where its axis meets the surface
  NeedleState state;

  double depth() const { return -dot(pose.position - entry, pose.axes.column[2]); }
  /// Moves the tip to a depth by `step` a tick; visit(depth, force along the needle) after every tick.
  template <class Visit>
  void move_to(double to, double step, const Visit& visit) {
    const int ticks = std::max(1, int(std::lround(std::abs(to - depth()) / step)));
    const double each = (to - depth()) / ticks;
    for (int i = 0; i < ticks; i++) {
      pose.position -= pose.axes.column[2] * each;
      const ToolReading reading = tick_needle(block.inner, needle, {}, pose, 1, state);
      visit(depth(), dot(reading.force, pose.axes.column[2]));
    }
  }
  void move_to(double to, double step = 4e-5) {
    move_to(to, step, [](double, double) {});
  }
  double energy_error() const {
    const NeedleWork& w = state.work;
    return (w.cutting + w.friction + w.spreading + w.elastic) / w.hand - 1;
  }
};

inline Insertion above(const NeedleBlock& block, const Needle& needle, double tilt = 0, double around = 0) {
  Insertion insertion{block,
                      needle,
                      {},
                      {0.52 * block.width, 0.47 * block.width, block.height},
                      make_needle_state(block.inner, needle)};
  insertion.pose.axes = tilted_axes(tilt, around);
  insertion.pose.position = insertion.entry + insertion.pose.axes.column[2] * 0.001;
  return insertion;
}

}  // namespace turgor::contact::test_needles
