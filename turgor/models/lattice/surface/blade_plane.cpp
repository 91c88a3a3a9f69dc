#include "turgor/models/lattice/surface/blade_plane.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace turgor::lattice {

std::vector<CutPoint> cut_points_near(const Fragments& fragments, const Cuts& cuts, Int3 cell) {
  const FineLattice& f = fragments.fine;
  const Int3 first = first_of_cell(f, cell), low = max(first - Int3{1, 1, 1}, Int3{0, 0, 0}),
             high = min(first + f.subdivisions + Int3{1, 1, 1}, f.size - Int3{1, 1, 1});
  std::vector<CutPoint> points;
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++)
        for (const Int3 offset : kFamilies) {
          const Int3 a{i, j, k}, b = a + offset;
          if (!(b == min(b, high))) continue;
          const Crossing c = crossing(fragments, cuts, a, b);
          if (c.edge == nullptr) continue;
          const Vec3d from = lattice_index(f, a);
          points.push_back(
              {from + (lattice_index(f, b) - from) * double(c.fraction), c.edge->along, c.edge->incision});
        }
  return points;
}

std::optional<BladePlane> blade_plane_near(const FineLattice& fine, std::span<const CutPoint> points,
                                           std::uint8_t incision, Real along, Vec3d position) {
  constexpr double kRounding = 0.1;   // of the weights near a cut point [squared fine edges]
  constexpr double kReach = 2.5;      // distance of cut points [fine edges]
  constexpr double kFarthest = 3;     // arc length of other cut points [fine edges]
  constexpr double kThinnest = 0.02;  // least width of the cut points, relative to their length
  const Vec3d subdivisions(fine.subdivisions);
  const Vec3 h = fine.cells.spacing;
  const double farthest = kFarthest * std::max({double(h.x) / subdivisions.x, double(h.y) / subdivisions.y,
                                                double(h.z) / subdivisions.z});
  // weighted center and moments, in fine edges
  double total = 0;
  int count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const CutPoint& point : points) {
    if (point.incision != incision || std::abs(double(point.along - along)) > farthest) continue;
    const Vec3d d = hadamard(point.position - position, subdivisions);
    if (dot(d, d) > kReach * kReach) continue;
    const double weight = 1 / ((dot(d, d) + kRounding) * (dot(d, d) + kRounding));
    const Eigen::Vector3d offset(d.x, d.y, d.z);
    total += weight, count++, sum += weight * offset, moments += weight * offset * offset.transpose();
  }
  if (count < 3) return {};
  const Eigen::Vector3d center = sum / total;
  // direction of least variance
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments / total - center * center.transpose());
  if (!(solver.eigenvalues()[1] > kThinnest * kThinnest * solver.eigenvalues()[2])) return {};
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  return BladePlane{
      position + Vec3d{center[0] / subdivisions.x, center[1] / subdivisions.y, center[2] / subdivisions.z},
      hadamard(Vec3d{n[0], n[1], n[2]}, subdivisions)};
}

}  // namespace turgor::lattice
