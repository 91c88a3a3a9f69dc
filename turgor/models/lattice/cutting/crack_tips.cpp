#include "turgor/models/lattice/cutting/crack_tips.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Calls visit(edge, cut position, edge vector pointing to the right) for the cut edges in the 27 cells
/// around a cell.
template <class Visit>
void for_cuts_around(const Cuts& cuts, const Fragments& fragments, const CutEdgesByCell& edges, Int3 cell,
                     int incision, const Visit& visit) {
  const FineLattice& f = fragments.fine;
  const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
             high = min(cell + Int3{1, 1, 1}, f.cells.size - Int3{2, 2, 2});
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) {
        const int index = fragments.cell_index.find(std::uint64_t(node_slot(f.cells, i, j, k)));
        auto at = std::lower_bound(edges.pairs.begin(), edges.pairs.end(), std::pair(index, -1));
        for (; index >= 0 && at != edges.pairs.end() && at->first == index; ++at) {
          const CutEdge& edge = cuts.edges[std::size_t(at->second)];
          if (incision >= 0 && edge.incision != incision) continue;
          const Int3 a = fine_node(f, edge), b = a + kFamilies[edge.family];
          const Vec3d from = lattice_index(f, a), direction = lattice_index(f, b) - from;
          visit(edge, from + direction * double(edge.fraction), edge.rightward ? direction : -direction);
        }
      }
}

/// Eigenvector of the smallest eigenvalue of a covariance matrix.
Vec3d least_spread_direction(const Eigen::Matrix3d& spread) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  return {n[0], n[1], n[2]};
}

/// True if the plane of a blade that crosses no sample line of a cell passes through corners of the cell, and
/// no other cell with these corners is crossed: the blade passes beside the cell then.
bool is_touched(const Cuts& cuts, const Fragments& fragments, const CutCell& cell, const CrackTipPlane& plane,
                std::uint8_t incision) {
  constexpr double kGrazing = 0.06;  // [cells]; with 0.2 a tilted wound gaped by a sixth less
  // corners on the plane, and beside it
  const Lattice& l = fragments.fine.cells;
  const Int3 corner = slot_node(l, cell.slot);
  int on_plane = 0;
  bool is_left = false, is_right = false;
  for (int n = 0; n < 8; n++) {
    const double distance = plane.signed_distance(Vec3d(in_body(l, corner + cell_corner(n))));
    if (std::abs(distance) < kGrazing) on_plane |= 1 << n;
    is_left |= distance <= -kGrazing, is_right |= distance >= kGrazing;
  }
  if (on_plane == 0) return false;
  if (is_left && is_right) return true;
  // cells around that have all corners on the plane
  for (int n = 0; n < 27; n++) {
    const Int3 offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}, other = corner + offset;
    bool has_all = contains(l, other) && contains(l, other + Int3{1, 1, 1});
    for (int c = 0; c < 8; c++) {
      const Int3 own = cell_corner(c) - offset;
      has_all = has_all && (!(on_plane >> c & 1) || (own == min(max(own, Int3{0, 0, 0}), Int3{1, 1, 1})));
    }
    if (has_all && is_sampled(cuts, node_slot(l, other), incision)) return false;
  }
  return true;
}

/// True if the cuts of an incision around a cell lie before its own cuts along the blade, or all beyond them.
bool is_last_along(const Cuts& cuts, const Fragments& fragments, const CutEdgesByCell& edges,
                   const CutCell& cell, std::uint8_t incision) {
  constexpr Real kNear = 0.25;  // [cells]
  const Vec3 h = fragments.fine.cells.spacing;
  const Real near = kNear * std::min({h.x, h.y, h.z});
  // mean position of the cell's own cuts
  const int index = int(&cell - fragments.cells.data());
  Real sum = 0;
  int count = 0;
  auto at = std::lower_bound(edges.pairs.begin(), edges.pairs.end(), std::pair(index, -1));
  for (; at != edges.pairs.end() && at->first == index; ++at)
    if (const CutEdge& edge = cuts.edges[std::size_t(at->second)]; edge.incision == incision)
      sum += edge.along, count++;
  if (count == 0) return false;
  // cuts before and beyond it
  bool any_before = false, any_beyond = false;
  for_cuts_around(cuts, fragments, edges, slot_node(fragments.fine.cells, cell.slot), incision,
                  [&](const CutEdge& edge, Vec3d, Vec3d) {
                    any_before |= edge.along < sum / Real(count) - near;
                    any_beyond |= edge.along > sum / Real(count) + near;
                  });
  return any_before != any_beyond;
}

}  // namespace

Vec3d flattest_direction(const std::vector<Vec3d>& positions) {
  Vec3d center;
  TURGOR_CHECK(!positions.empty(), "a plane is fitted to at least one point");
  for (const Vec3d position : positions) center += position / double(positions.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3d position : positions) {
    const Eigen::Vector3d d(position.x - center.x, position.y - center.y, position.z - center.z);
    spread += d * d.transpose();
  }
  return least_spread_direction(spread);
}

bool has_cut_edge(const Cuts& cuts, const Lattice& lattice, int slot) {
  return has_cut_edge(cuts.cut.data(), lattice, slot);
}

std::optional<CrackTipPlane> fit_crack_tip_plane(const Cuts& cuts, const Fragments& fragments,
                                                 const CutEdgesByCell& edges, const CutCell& cell,
                                                 int incision) {
  const Int3 corner = slot_node(fragments.fine.cells, cell.slot);
  // weighted center and mean edge vector; the weights decay with distance from the cell center
  const Vec3d middle = Vec3d(in_body(fragments.fine.cells, corner)) + Vec3d{0.5, 0.5, 0.5};
  double total = 0;
  Vec3d center, right;
  const auto weight_at = [&](Vec3d position) {
    const Vec3d offset = position - middle;
    return 1 / ((1 + dot(offset, offset)) * (1 + dot(offset, offset)));
  };
  for_cuts_around(cuts, fragments, edges, corner, incision,
                  [&](const CutEdge&, Vec3d position, Vec3d direction) {
                    const double weight = weight_at(position);
                    total += weight, center += position * weight, right += direction * weight;
                  });
  // covariance; its smallest eigenvector is the normal
  if (!(total > 0)) return {};
  center = center / total;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for_cuts_around(cuts, fragments, edges, corner, incision, [&](const CutEdge&, Vec3d position, Vec3d) {
    const Eigen::Vector3d d(position.x - center.x, position.y - center.y, position.z - center.z);
    spread += weight_at(position) * d * d.transpose();
  });
  const Vec3d normal = least_spread_direction(spread);
  TURGOR_CHECK(is_unit(normal), "the normal of a crack tip is a unit vector");
  return CrackTipPlane{center, dot(normal, right) < 0 ? -normal : normal};
}

bool is_behind_end(const Cuts& cuts, const Fragments& fragments, const CutEdgesByCell& edges,
                   const CutCell& cell, const CrackTipPlane& plane, std::uint8_t incision) {
  return !is_sampled(cuts, cell.slot, incision) && is_touched(cuts, fragments, cell, plane, incision) &&
         is_last_along(cuts, fragments, edges, cell, incision);
}

}  // namespace turgor::lattice
