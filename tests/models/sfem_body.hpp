// Small bodies for tests of sfem, and their Green's functions by a dense inverse.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

inline Body held_body(SolidMesh mesh, Material material, const std::function<bool(Vec3d)>& is_fixed) {
  Body body;
  for (const Vec3d x : mesh.vertices) body.fixed.push_back(is_fixed(x));
  body.mesh = std::move(mesh);
  body.materials = {material};
  return body;
}

/// The paper's plate: all four sides clamped over the full thickness.
inline Body plate(Int3 count) {
  return held_body(hex_block({0.1, 0.1, 0.01}, count), {1e5, 0.4},
                   [](Vec3d x) { return x.x < 1e-9 || x.y < 1e-9 || x.x > 0.1 - 1e-9 || x.y > 0.1 - 1e-9; });
}

inline Eigen::MatrixXd dense(const BlockMatrix& k) {
  const Eigen::Index rows = 3 * Eigen::Index(k.row_begin.size() - 1);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t r = 0; r + 1 < k.row_begin.size(); r++)
    for (std::size_t b = k.row_begin[r]; b < k.row_begin[r + 1]; b++)
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          m(3 * Eigen::Index(r) + i, 3 * k.column[b] + j) =
              k.value[9 * b + 3 * std::size_t(i) + std::size_t(j)];
  return m;
}

/// A model whose Green's functions come from Eigen's dense inverse.
inline Model densely_solved(Body body, const Params& params) {
  Result<Model> built = build(Exec(1), std::move(body), params);
  EXPECT_TRUE(built) << built.error().message;
  Model model = std::move(*built);
  const Eigen::MatrixXd inverse = dense(model.stiffness).inverse();
  const Eigen::Index kept = 3 * Eigen::Index(model.green.nodes.size());
  Eigen::MatrixXd green(kept, kept);
  for (Eigen::Index i = 0; i < kept / 3; i++)
    for (Eigen::Index j = 0; j < kept / 3; j++) {
      const auto row = [&](Eigen::Index slot) {
        return 3 * model.free_node[std::size_t(model.green.nodes[std::size_t(slot)])];
      };
      green.block<3, 3>(3 * i, 3 * j) = inverse.block<3, 3>(row(i), row(j));
    }
  if (params.precision == Precision::kDouble)
    model.green.double_values.assign(green.data(), green.data() + green.size());
  else
    model.green.single_values.assign(green.data(), green.data() + green.size());
  return model;
}

/// Moves inner vertices about, so that no element is like another. Faces of the block stay plane.
inline void distort(SolidMesh& mesh, Vec3d size, double amount) {
  unsigned random = 1;
  const auto next = [&random] {
    random = random * 1664525u + 1013904223u;
    return double(random >> 8) / (1 << 24) - 0.5;
  };
  for (Vec3d& x : mesh.vertices)
    for (int axis = 0; axis < 3; axis++) {
      const double shift = amount * next();
      if (x[axis] > 1e-9 && x[axis] < size[axis] - 1e-9) x[axis] += shift;
    }
}

}  // namespace turgor::sfem
