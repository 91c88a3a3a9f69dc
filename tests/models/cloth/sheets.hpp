// Sheets for tests of the cloth model.
#pragma once

#include <gtest/gtest.h>

#include "tests/models/cloth/storm.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/measure.hpp"

namespace turgor::cloth {

constexpr double kFrame = 1.0 / 60;

/// A horizontal square of n × n vertices with a spacing.
inline TriMesh flat_sheet(int n, double spacing = 0.01) {
  return make_sheet(
      {.side = {spacing * (n - 1), 0, 0}, .up = {0, spacing * (n - 1), 0}, .columns = n - 1, .rows = n - 1});
}

inline Model must_build(const TriMesh& mesh, const Params& params) {
  Result<Model> model = build(Exec(1), mesh, params);
  return std::move(*model);
}

/// Gravity only, without air.
inline Inputs in_vacuum(double g = 9.81) {
  Inputs inputs{.gravity = {0, 0, -g}};
  inputs.air.density = 0;
  return inputs;
}

/// Adds pseudorandom vectors of up to `size` per axis to every vertex.
inline void shake(const Model& model, Vectors& field, double size, unsigned seed = 1) {
  RandomNumbers next{seed};
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    const double x = next(), y = next(), z = next();
    field.add(v, Vec3(Vec3d{x, y, z} * size));
  }
}

}  // namespace turgor::cloth
