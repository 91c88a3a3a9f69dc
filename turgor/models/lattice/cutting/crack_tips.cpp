#include "turgor/models/lattice/cutting/crack_tips.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Calls visit(edge, where it is cut, the way across to the right) for the cut edges of the cells around one.
template <class Visit>
void for_cuts_around(const State& state, const Fragments& pieces, const EdgesOfCells& edges, Int3 cell,
                     int incision, const Visit& visit) {
  const FineLattice& f = pieces.fine;
  const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
             high = min(cell + Int3{1, 1, 1}, f.cells.size - Int3{2, 2, 2});
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) {
        const int index = pieces.cell_index.find(std::uint64_t(node_slot(f.cells, i, j, k)));
        auto at = std::lower_bound(edges.pairs.begin(), edges.pairs.end(), std::pair(index, -1));
        for (; index >= 0 && at != edges.pairs.end() && at->first == index; ++at) {
          const CutEdge& edge = state.cut_edges[std::size_t(at->second)];
          if (incision >= 0 && edge.incision != incision) continue;
          const Int3 a = fine_node(f, edge), b = a + kFamilies[edge.family];
          const Vec3d from = lattice_index(f, a), way = lattice_index(f, b) - from;
          visit(edge, from + way * double(edge.fraction), edge.rightward ? way : -way);
        }
      }
}

/// The direction of the least spread.
Vec3d least_way(const Eigen::Matrix3d& spread) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  return {n[0], n[1], n[2]};
}

}  // namespace

Vec3d flattest_way(const std::vector<Vec3d>& places) {
  Vec3d center;
  for (const Vec3d place : places) center += place / double(places.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3d place : places) {
    const Eigen::Vector3d d(place.x - center.x, place.y - center.y, place.z - center.z);
    spread += d * d.transpose();
  }
  return least_way(spread);
}

bool has_cut_edge(const State& state, const Lattice& lattice, int slot) {
  return has_cut_edge(state.cut.data(), lattice, slot);
}

std::optional<CrackTipPlane> fit_tip(const State& state, const Fragments& pieces, const EdgesOfCells& edges,
                                     const CutCell& cell, int incision) {
  const Int3 corner = slot_node(pieces.fine.cells, cell.slot);
  const Vec3d middle = Vec3d(in_body(pieces.fine.cells, corner)) + Vec3d{0.5, 0.5, 0.5};
  double total = 0;
  Vec3d center, right;
  const auto weight_at = [&](Vec3d place) {
    const Vec3d apart = place - middle;
    return 1 / ((1 + dot(apart, apart)) * (1 + dot(apart, apart)));
  };
  for_cuts_around(state, pieces, edges, corner, incision, [&](const CutEdge&, Vec3d place, Vec3d way) {
    const double weight = weight_at(place);
    total += weight, center += place * weight, right += way * weight;
  });
  if (!(total > 0)) return {};
  center = center / total;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for_cuts_around(state, pieces, edges, corner, incision, [&](const CutEdge&, Vec3d place, Vec3d) {
    const Eigen::Vector3d d(place.x - center.x, place.y - center.y, place.z - center.z);
    spread += weight_at(place) * d * d.transpose();
  });
  const Vec3d normal = least_way(spread);
  return CrackTipPlane{center, dot(normal, right) < 0 ? -normal : normal};
}

}  // namespace turgor::lattice
