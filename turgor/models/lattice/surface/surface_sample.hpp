// Places of the surface that tools touch, and which of them come near.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/config.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct SurfaceSample {
  int slot = 0;       // of the node that carries it
  Vec3d rest;         // as in the CT, lattice frame [m]
  bool wall = false;  // of a cut
  int other = -1;     // of a neighbour that carries it as well, and has a place of its own there
};

/// The mean of a field at a place. `field(slot)`: a Vec3.
template <class Field>
TURGOR_HD inline Vec3d mean_at(const SurfaceSample& place, const Field& field) {
  const Vec3d own(field(place.slot));
  return place.other < 0 ? own : (own + Vec3d(field(place.other))) * 0.5;
}

struct Ball {
  Vec3d center;       // lattice frame [m]
  double radius = 0;  // [m]
};

/// Is a point inside?
TURGOR_HD inline bool contains(const Ball& ball, Vec3d x) {
  const Vec3d apart = x - ball.center;
  return dot(apart, apart) < ball.radius * ball.radius;
}

/// Those that are inside any of the balls where the body is now, ascending.
std::vector<int> places_in(std::span<const SurfaceSample> places, const State& state,
                           std::span<const Ball> balls);

}  // namespace turgor::lattice
