#include "turgor/models/lattice/surface/onto_blades.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/kuhn_raster.hpp"

namespace turgor::lattice {

void LevelsNear::begin_cell(Int3 cell) {
  cell_ = cell;
  levels_.fill({});
}

const CellLevels& LevelsNear::levels_of(Int3 cell) {
  const Int3 offset = cell - cell_ + Int3{1, 1, 1};
  std::optional<CellLevels>& levels = levels_[std::size_t(offset.x + 3 * (offset.y + 3 * offset.z))];
  if (!levels) levels = level_(node_slot(fine_.cells, cell));
  return *levels;
}

LevelAt LevelsNear::at(Vec3d position) {
  const Vec3d fine = hadamard(position - Vec3d{0, 0, double(fine_.cells.first)}, Vec3d(fine_.subdivisions));
  // fine cube that contains the position
  const Int3 low = hadamard(max(cell_ - Int3{1, 1, 1}, Int3{0, 0, 0}), fine_.subdivisions),
             high =
                 hadamard(min(cell_ + Int3{2, 2, 2}, fine_.cells.size - Int3{1, 1, 1}), fine_.subdivisions);
  Int3 cube;
  Vec3d in_cube;
  for (int axis = 0; axis < 3; axis++) {
    cube[axis] = std::clamp(int(std::floor(fine[axis])), low[axis], high[axis] - 1);
    in_cube[axis] = std::clamp(fine[axis] - cube[axis], 0.0, 1.0);
  }
  // levels at the corners of its tetrahedron
  const Int3 cell = cell_of(fine_, cube);
  const CellLevels& levels = levels_of(cell);
  const int tet = kuhn_tet_at(in_cube);
  const std::array<Int3, 4> corners = kuhn_corners(cube - first_of_cell(fine_, cell), tet);
  const Int3 path = kuhn_path(tet);
  const auto level = [&](std::size_t n) {
    return double(levels.at[std::size_t(sub_index(fine_, corners[n]))]);
  };
  LevelAt found{level(0), {}};
  for (std::size_t n = 0; n < 3; n++) {
    const int axis = path[int(n)];
    const double slope = level(n + 1) - level(n);
    found.level += slope * in_cube[axis];
    found.gradient[axis] = slope * fine_.subdivisions[axis];
  }
  return found;
}

std::optional<Vec3d> SkinOnBlades::operator()(std::span<const CutEdge* const> blades, Vec3d position,
                                              double reach) const {
  constexpr int kRounds = 6;            // the planes change with the position
  constexpr double kConverged = 0.02;   // [fine edges]
  constexpr double kLongestMove = 0.7;  // in a round [fine edges]
  constexpr double kParallel[] = {0, 0, 0.05,
                                  0.0045};  // least Gram determinant of two and of three unit normals
  TURGOR_CHECK(!blades.empty() && blades.size() < 3, "the skin meets one or two blades");
  const Vec3d subdivisions(fine.subdivisions), from = position;
  const int rows = int(blades.size()) + 1;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> normals(rows, 3);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> distances(rows);
  for (int round = 0; round < kRounds; round++) {
    // unit normals and distances, in fine edges
    const auto set_row = [&](int row, Vec3d normal, double value) {
      Vec3d n{normal.x / subdivisions.x, normal.y / subdivisions.y, normal.z / subdivisions.z};
      const double size = norm(n);
      if (!(size > 0)) return false;
      normals.row(row) << n.x / size, n.y / size, n.z / size;
      distances(row) = value / size;
      return true;
    };
    const LevelAt skin = levels.at(position);
    if (!set_row(0, skin.gradient, skin.level)) return {};
    for (int b = 0; b < int(blades.size()); b++) {
      const CutEdge& edge = *blades[std::size_t(b)];
      const auto plane = blade_plane_near(fine, cut_points, edge.incision, edge.along, position);
      if (!plane || !set_row(b + 1, plane->normal, dot(position - plane->point, plane->normal))) return {};
    }
    if (distances.cwiseAbs().maxCoeff() < kConverged) return position;
    // shortest move that reaches all of them
    const auto gram = (normals * normals.transpose()).eval();
    if (!(gram.determinant() > kParallel[rows])) return {};
    Eigen::Vector3d move = -normals.transpose() * gram.inverse() * distances;
    if (move.norm() > kLongestMove) move *= kLongestMove / move.norm();
    position += Vec3d{move[0] / subdivisions.x, move[1] / subdivisions.y, move[2] / subdivisions.z};
    if (!(dot(position - from, position - from) < reach * reach)) return {};
  }
  return {};
}

}  // namespace turgor::lattice
