// Samples of the surface for tool contact, and the samples inside given balls.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/config.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct SurfaceSample {
  int slot = 0;       // node that moves the sample
  Vec3d rest;         // rest position, lattice frame [m]
  bool wall = false;  // on the wall of a cut
  int other = -1;     // neighbor that moves it as well, and has a coincident sample of its own; < 0 = none
};

/// Mean of a field over the nodes of a sample. field(slot) returns a Vec3.
template <class Field>
TURGOR_HD inline Vec3d mean_at(const SurfaceSample& sample, const Field& field) {
  const Vec3d own(field(sample.slot));
  return sample.other < 0 ? own : (own + Vec3d(field(sample.other))) * 0.5;
}

struct Ball {
  Vec3d center;       // lattice frame [m]
  double radius = 0;  // [m]
};

/// True if the point is inside the ball.
TURGOR_HD inline bool contains(const Ball& ball, Vec3d x) {
  const Vec3d apart = x - ball.center;
  return dot(apart, apart) < ball.radius * ball.radius;
}

/// Indices of the samples whose current positions are inside any of the balls, ascending.
std::vector<int> samples_in_balls(std::span<const SurfaceSample> samples, const Motion& motion,
                                  std::span<const Ball> balls);

}  // namespace turgor::lattice
