// Green's functions of small bodies by a dense inverse: slow, and independent of how the engine gets them.
#pragma once

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "models/sfem_bodies.hpp"

namespace turgor::sfem {

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

}  // namespace turgor::sfem
