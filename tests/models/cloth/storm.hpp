// Random steps of a small cloth: holds that jump by up to twice the sheet's length in a frame, and storms.
// Reproducible, and independent of the test library, since a benchmark uses it too.
#pragma once

#include <cstdint>

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

/// Pseudorandom numbers in [-1, 1).
struct RandomNumbers {
  std::uint64_t bits;

  double operator()() {
    bits = bits * 6364136223846793005ull + 1442695040888963407ull;
    return double(bits >> 40) / double(1 << 23) - 1;
  }
};

/// Holds, releases and moves vertices of a sheet of 9 × 9 and steps it in wind of random direction,
/// optionally with `gusts`.
inline StepReport storm_step(const Exec& exec, const Model& model, State& state, RandomNumbers& next,
                             bool gusts) {
  const int vertex = int(40 + 40 * next());
  if (next() > 0.95) (void)hold(model, state, vertex);
  if (next() > 0.95) (void)release(model, state, vertex);
  const double hx = next(), hy = next(), hz = next();
  (void)move_hold(model, state, vertex, Vec3(Vec3d{hx, hy, hz} * 0.2));
  const double gx = next(), gy = next(), gz = next();
  Inputs inputs{.gravity = Vec3d{gx, gy, gz} * 20.0};
  const double wx = next(), wy = next(), wz = next();
  inputs.air.velocity = Vec3d{wx, wy, wz} * 30.0;
  if (gusts) inputs.air.gusts = 0.5 + 0.5 * next();
  return step(exec, model, state, inputs, 0.017 + 0.016 * next());
}

}  // namespace turgor::cloth
