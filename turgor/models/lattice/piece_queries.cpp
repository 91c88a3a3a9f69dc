// What is asked of the pieces of a cut body: where an edge is cut, which piece holds a point, where a corner
// is.
#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/follow.hpp"
#include "turgor/models/lattice/pieces.hpp"
#include "turgor/models/lattice/raster.hpp"
#include "turgor/models/lattice/tip_cells.hpp"

namespace turgor::lattice {

namespace {

bool is_negative(Int3 d) { return d.x < 0 || d.y < 0 || d.z < 0; }

/// As it is cut now.
struct CutBody {
  const Model& model;
  const State& state;

  bool is_solid(int slot) const { return lattice::is_solid(model, state, slot); }
  Vec3 u(int slot) const { return state.u[std::size_t(slot)]; }
  bool is_parted(int beside, int behind, Int3 way) const {
    const Lattice& l = model.lattice;
    const bool up = family_of(way) >= 0;
    if (const int family = up ? family_of(way) : family_of(-way); family >= 0)
      return state.cut[std::size_t(up ? beside : behind)] >> family & 1;
    return has_cut_edge(state, l, node_slot(l, slot_node(l, beside) + min(way, Int3{0, 0, 0})));
  }
};

/// Corner levels of a tetrahedron whose corners have two labels, so that they vanish where its edges are cut:
/// positive where the label is that of the first.
std::array<Real, 4> two_sides(const Pieces& pieces, const State& state, const std::array<Int3, 4>& nodes,
                              const std::array<int, 4>& label) {
  std::array<Real, 4> level{};
  std::array<int, 4> count{};
  const auto cut = [&](std::size_t a, std::size_t b) {
    const Crossing found = crossing(pieces, state, nodes[a], nodes[b]);
    return found.edge ? std::clamp(found.fraction, Real(0.01), Real(0.99)) : Real(0.5);  // beyond the tip
  };
  level[0] = 1;
  for (std::size_t b = 1; b < 4; b++)  // across from the first, then back
    if (label[b] != label[0]) level[b] = 1 - 1 / cut(0, b);
  for (std::size_t a = 1; a < 4; a++) {
    if (label[a] != label[0]) continue;
    for (std::size_t b = 1; b < 4; b++)
      if (label[b] != label[0]) level[a] -= level[b] * cut(a, b) / (1 - cut(a, b)), count[a]++;
    level[a] /= Real(std::max(1, count[a]));
  }
  return level;
}

}  // namespace

Crossing crossing(const Pieces& pieces, const State& state, Int3 a, Int3 b) {
  const bool swapped = is_negative(b - a);
  if (swapped) std::swap(a, b);
  const int index = pieces.edge_index.find(fine_edge_key(pieces.fine, a, family_of(b - a)));
  if (index < 0) return {};
  const CutEdge& edge = state.cut_edges[std::size_t(index)];
  return {.edge = &edge,
          .fraction = swapped ? 1 - edge.fraction : edge.fraction,
          .rightward = (edge.rightward != 0) != swapped};
}

int piece_at(const Pieces& pieces, const State& state, const CutCell& cell, Vec3 at) {
  if (cell.piece_count < 2) return cell.piece_count - 1;
  const FineLattice& f = pieces.fine;
  Vec3 in_part;
  Int3 part;
  for (int axis = 0; axis < 3; axis++) {
    const Real x = at[axis] * Real(f.parts[axis]);
    part[axis] = std::clamp(int(std::floor(x)), 0, f.parts[axis] - 1);
    in_part[axis] = std::clamp(x - Real(part[axis]), Real(0), Real(1));
  }
  const int tet = kuhn_tet_at(in_part);
  const std::array<Int3, 4> corners = kuhn_corners(part, tet);
  const std::array<Real, 4> weight = path_weights(tet, in_part);
  std::array<int, 4> label;
  bool two = true;
  int other = -1;
  for (std::size_t n = 0; n < 4; n++) {
    label[n] = piece_of(pieces, cell, place_in_cell(f, corners[n]));
    if (label[n] == label[0]) continue;
    two &= other < 0 || label[n] == other;
    other = label[n];
  }
  if (other < 0) return label[0];
  if (!two) return label[std::size_t(std::max_element(weight.begin(), weight.end()) - weight.begin())];
  std::array<Int3, 4> nodes;
  for (std::size_t n = 0; n < 4; n++) nodes[n] = first_of_cell(f, slot_node(f.cells, cell.slot)) + corners[n];
  const std::array<Real, 4> level = two_sides(pieces, state, nodes, label);
  Real sum = 0;
  for (std::size_t n = 0; n < 4; n++) sum += level[n] * weight[n];
  return sum >= 0 ? label[0] : other;
}

Vec3 corner_displacement(const Model& model, const State& state, const Pieces& pieces, int corner) {
  const int slots = slot_count(model.lattice);
  const NodeCopy* copy = corner < slots ? nullptr : &pieces.copies[std::size_t(corner - slots)];
  if (copy != nullptr && copy->bears && state.copies.size() == pieces.copies.size()) {
    const CopyShift& u = state.copies[std::size_t(corner - slots)];
    return {u.x, u.y, u.z};
  }
  if (copy == nullptr || copy->source_count == 0) {  // a crumb without a node of its own goes with its node
    const int slot = copy ? copy->slot : corner;
    return is_solid(model, state, slot) ? state.u[std::size_t(slot)]
                                        : follow_neighbours(model.lattice, CutBody{model, state}, slot);
  }
  Vec3 sum;
  for (int s = copy->first; s < copy->first + copy->source_count; s++) {
    const CopySource& source = pieces.sources[std::size_t(s)];
    sum += corner_displacement(model, state, pieces, source.corner) * source.weight;
  }
  return sum;
}

std::array<int, 8> corners_of(const Model& model, const Pieces& pieces, int slot, int piece) {
  if (piece >= 0)
    if (const CutCell* cell = find_cell(pieces, slot); cell && piece < cell->piece_count)
      return pieces.pieces[std::size_t(cell->first_piece + piece)].corner;
  std::array<int, 8> corners;
  const int parity = slot_node(model.lattice, slot).x & 1;
  for (int c = 0; c < 8; c++)
    corners[std::size_t(c)] = slot + slot_offset(model.lattice, {c & 1, c >> 1 & 1, c >> 2}, parity);
  return corners;
}

}  // namespace turgor::lattice
