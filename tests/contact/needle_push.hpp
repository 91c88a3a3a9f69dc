// A needle that moves along its axis in a lattice block, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/contact/lattice_needle.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact::test_needles {

constexpr double kFrame = 1.0 / 60;

/// Block of tissue that is fixed at its bottom, or at its sides, under a needle.
struct LatticeNeedleBlock {
  Int3 size{17, 17, 13};
  double spacing = 0.004, young = 4e3, poisson = 0.45;
  bool are_sides_fixed = false;
  double tension = 0;  // of a skin on top; 0 = no skin [N/m]
  int sweeps = 10, threads = 1;
  lattice::Model model = {};
  lattice::State state = {};
  lattice::BodySurface surface = {};

  void build() {
    lattice::Params params;
    params.skin.enabled = tension > 0;
    params.skin.tension_along = params.skin.tension_across = tension;
    params.tissue.law = lattice::TissueLaw::kSolid, params.tissue.poisson = poisson;
    params.solver = {.sweeps = sweeps, .damping = 8};
    const auto is_fixed = [this](Int3 n) {
      if (!are_sides_fixed) return n.z == 0;
      return n.x == 0 || n.y == 0 || n.x == size.x - 1 || n.y == size.y - 1;
    };
    model = lattice::block_model({.size = size, .spacing = spacing, .young = young, .is_fixed = is_fixed},
                                 params);
    state = lattice::make_state(model);
    surface = lattice::build_surface(model, state.cuts);
  }
  double top() const {
    float z = 0;
    for (const Vec3 x : surface.rest) z = std::max(z, x.z);
    return double(z);
  }
};

/// Axes whose z axis is tilted from the vertical toward a direction around it [rad].
inline Mat3d axes_at(double tilt, double around) {
  const Vec3d z{std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt)};
  const Vec3d x = normalized(cross(Vec3d{0.3, 1, 0}, z));
  return {{x, cross(z, x), z}};
}

/// A needle that moves along its axis.
struct NeedlePush {
  LatticeNeedleBlock& block;
  Needle needle;
  Vec3d entry = {};  // where its axis meets the surface
  Pose pose = {};
  LatticeNeedle state = make_lattice_needle();
  std::function<NeedleTissue(Vec3d)> tissue_at = of_needle;

  NeedlePush(LatticeNeedleBlock& of, const Needle& made, double tilt = 0, double around = 0)
      : block(of), needle(made) {
    block.build();
    const double width = (block.size.x - 1) * block.spacing;
    entry = {0.52 * width, 0.47 * width, block.top()};
    pose.axes = axes_at(tilt, around);
    pose.position = entry + pose.axes.column[2] * 0.002;
    hold(1);
  }
  double depth() const { return -dot(pose.position - entry, pose.axes.column[2]); }
  double force() const { return dot(state.force, pose.axes.column[2]); }
  void hold(int steps) {
    for (int i = 0; i < steps; i++)
      EXPECT_TRUE(step_with_needle(Exec(block.threads), block.model, block.state, block.surface, needle, pose,
                                   {}, kFrame, state, tissue_at)
                      .finite);
  }
  /// Moves the tip to a depth by about `step` a frame; visit() after every frame.
  template <class Visit>
  void move_to(double to, double step, const Visit& visit) {
    const int frames = std::max(1, int(std::lround(std::abs(to - depth()) / step)));
    const double each = (to - depth()) / frames;
    for (int i = 0; i < frames; i++) {
      pose.position -= pose.axes.column[2] * each;
      hold(1);
      visit();
    }
  }
  void move_to(double to, double step = 2.5e-4) {
    move_to(to, step, [] {});
  }
  double energy_error() const {
    const NeedleWork& w = state.work;
    return (w.cutting + w.friction + w.spreading + w.elastic) / w.hand - 1;
  }
};

/// A block that resists, and a needle that punctures it within a few millimeters.
inline LatticeNeedleBlock firm_block(double spacing = 0.004, Int3 size = {15, 15, 11}) {
  return {.size = size, .spacing = spacing, .young = 1e4};
}

}  // namespace turgor::contact::test_needles
