// What cuts do to a tetrahedron. Its nodes are joined by its uncut edges; when they fall apart, each side is
// carried by its own nodes, and the nodes of the other sides are ghosts: they stand where this side's tissue
// would have taken them. A tetrahedron whose nodes still hold together (the front of a cut) is whole. Drawing
// and resampling share this view.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// A body with its cuts, made ready for questions. Refers to the model and the state.
struct CutBody {
  const Model& model;
  const State& state;
  std::vector<std::uint8_t> solid;  // by slot: 1 = tissue now: neither outside nor removed
  std::vector<std::pair<std::uint64_t, Real>> crossings;  // (slot · 8 + family, fraction), sorted
};

CutBody make_cut_body(const Model& model, const State& state);

inline bool is_solid(const CutBody& body, Int3 node) {
  return body.solid[std::size_t(node_slot(body.model.lattice, node))] != 0;
}
/// Is the edge between two neighbouring nodes cut? Only edges between solid nodes count.
bool is_cut(const CutBody& body, Int3 a, Int3 b);
/// Where the blade crossed a cut edge, as a fraction of the way from `a` to `b`.
Real crossing(const CutBody& body, Int3 a, Int3 b);

/// A linear function of lattice indices that vanishes where the blade went; its gradient has length 1, or 0
/// when there is none.
struct CutLevel {
  Vec3d origin, gradient;
  double offset = 0;

  double at(Vec3d index) const { return dot(gradient, index - origin) + offset; }
};
/// The blade near some neighbouring nodes, with given signs there (0 = unknown): the least squares fit
/// through the crossings of their edges, (AᵀA + ε) x = Σ sign · row. Edges to other nodes weigh little: they
/// speak where those between the nodes leave the plane open, as beside air.
CutLevel fit_level(const CutBody& body, std::span<const Int3> nodes, std::span<const int> signs);

/// The blade beside a node with cut edges, negative on the node's side; nothing for other nodes.
std::optional<CutLevel> level_beside(const CutBody& body, Int3 node);

using TetNodes = std::array<Int3, 4>;

/// The sides of a tetrahedron and which part of it each one owns.
struct TetSides {
  int count = 0;                 // 0 = no tissue, 1 = whole
  std::array<int, 4> side{};     // by node; -1 = not solid
  std::array<float, 4> level{};  // two sides: Σ level · weight ≥ 0 belongs to side 0, else to side 1
  std::array<bool, 4> removed{};
};
TetSides split_tet(const CutBody& body, const TetNodes& nodes);

/// The side that owns the point with these barycentric weights; -1 where the tissue was removed.
inline int side_at(const TetSides& sides, const std::array<float, 4>& weight) {
  float gone = 0, level = 0;
  std::size_t nearest = 0;
  for (std::size_t n = 0; n < 4; n++) {
    if (sides.removed[n]) gone += weight[n];
    level += sides.level[n] * weight[n];
    if (sides.side[nearest] < 0 || (sides.side[n] >= 0 && weight[n] > weight[nearest])) nearest = n;
  }
  if (gone > 0.5f) return -1;
  if (sides.count == 2) return level >= 0 ? 0 : 1;
  return sides.side[nearest];
}

/// The displacement of `node` as a ghost of the tissue around `seen_from` (its neighbour), which it is no
/// part of: what its neighbours there suggest, on average [m]. The same for all tetrahedra on that side, so
/// that they fit together.
Vec3 ghost_displacement(const CutBody& body, Int3 node, Int3 seen_from);

}  // namespace turgor::lattice
