// A layer of quadratic finite elements that is bonded to its base, for presses of a ball.
#pragma once

#include <cmath>

#include <gtest/gtest.h>

#include "tests/contact/axisymmetric.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::contact {

/// Planes from -far to far, `count` equal ones of this size in the middle.
inline std::vector<double> planes(double size, int count, double far) {
  std::vector<double> half;
  for (int i = 0; i <= count; i++) half.push_back(size * i);
  for (double step = size; half.back() < far;) half.push_back(half.back() + (step *= 1.6));
  half.back() = std::max(far, half[half.size() - 2] + size);
  std::vector<double> all;
  for (std::size_t i = half.size(); i-- > 1;) all.push_back(-half[i]);
  all.insert(all.end(), half.begin(), half.end());
  return all;
}

/// Layer of quadratic tetrahedra, its surface at z = 0.
inline sfem::Model layer_model(const PressedLayer& layer, double size, int cells) {
  const std::vector<double> across = planes(size, cells, layer.width);
  std::vector<double> down;
  const int levels = int(std::lround(layer.thickness / size));
  for (int i = 0; i <= levels; i++) down.push_back(layer.thickness * (double(i) / levels - 1));
  sfem::Body body{.mesh = turgor::with_middles(tetrahedralize(hex_block(across, across, down))),
                  .materials = {{layer.young, layer.poisson}}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < -layer.thickness + 1e-9);
  sfem::Model model = sfem::build(Exec(2), std::move(body), {.touch_depth = layer.thickness}).value();
  EXPECT_TRUE(sfem::prepare_columns(Exec(2), model));
  return model;
}

}  // namespace turgor::contact
