// Green's functions of small bodies by a dense inverse: slow, and independent of the engine.
#pragma once

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"

namespace turgor::sfem {

/// K as a dense matrix.
inline Eigen::MatrixXd dense(const BlockMatrix& k) {
  const auto rows = Eigen::Index(k.row_begin.size() - 1);
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
  for (Eigen::Index r = 0; r < rows; r++)
    for (std::size_t b = k.row_begin[std::size_t(r)]; b < k.row_begin[std::size_t(r) + 1]; b++)
      for (int i = 0; i < 9; i++)
        full(3 * r + i / 3, 3 * k.column[b] + i % 3) = k.value[9 * b + std::size_t(i)];
  return full;
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

}  // namespace turgor::sfem
