// What is asked of the pieces of a cut body: where an edge is cut, which piece holds a point, where a corner
// is.
#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/pieces.hpp"
#include "turgor/models/lattice/raster.hpp"
#include "turgor/models/lattice/tip_cells.hpp"

namespace turgor::lattice {

namespace {

bool is_negative(Int3 d) { return d.x < 0 || d.y < 0 || d.z < 0; }

struct MeanVec {
  Vec3 sum;
  int count = 0;

  void add(Vec3 v) { sum += v, count++; }
  Vec3 mean() const { return sum / Real(count); }
};

/// Of the tissue within two steps.
Vec3 mean_of_box(const Model& model, const State& state, Int3 node) {
  MeanVec mean;
  for (int n = 0; n < 125; n++) {
    const Int3 other = node + Int3{n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2};
    if (!contains(model.lattice, other)) continue;
    const int slot = node_slot(model.lattice, other);
    if (is_solid(model, state, slot)) mean.add(state.u[std::size_t(slot)]);
  }
  return mean.count > 0 ? mean.mean() : Vec3{};
}

/// Where the line from one node through the next leads after as long a way again. Tissue that is pressed
/// shorter between them is not drawn shorter beyond: there it bears nothing, and tools find it as thick as it
/// was.
Vec3 go_on(Vec3 behind, Vec3 here, Vec3 way) {
  const Vec3 now = way + (here - behind);
  const Real length = norm(way), length_now = norm(now);
  return length_now < length && length_now > 0 ? here + now * (length / length_now) - way : here + now - way;
}

/// What the tissue beside an air node suggests for its displacement, on average: it goes on along the line
/// through a neighbour from the node behind that, where there is one and no blade went between them; if not
/// along an axis, along another edge or across a cell; else it is that of the neighbours, or of the tissue
/// within two steps.
Vec3 follow_neighbours(const Model& model, const State& state, int slot) {
  const Lattice& l = model.lattice;
  const int parity = slot_node(l, slot).x & 1;
  MeanVec along_axis, along_edge, across_cell, beside_edge, beside_cell;
  for (int n = 0; n < 27; n++) {
    const Int3 way{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    const int beside = slot + slot_offset(l, way, parity);
    if (n == 13 || !is_solid(model, state, beside)) continue;
    const Vec3 here = state.u[std::size_t(beside)];
    const bool up = family_of(way) >= 0;
    const int family = up ? family_of(way) : family_of(-way);
    (family >= 0 ? beside_edge : beside_cell).add(here);
    const int behind = beside + slot_offset(l, way, (parity + way.x) & 1);
    if (!is_solid(model, state, behind)) continue;
    const bool is_parted =
        family >= 0 ? state.cut[std::size_t(up ? beside : behind)] >> family & 1
                    : has_cut_edge(state, l, node_slot(l, slot_node(l, beside) + min(way, Int3{0, 0, 0})));
    if (is_parted) continue;
    const bool is_axis = way.x * way.x + way.y * way.y + way.z * way.z == 1;
    (is_axis       ? along_axis
     : family >= 0 ? along_edge
                   : across_cell)
        .add(go_on(state.u[std::size_t(behind)], here, -hadamard(l.step, Vec3(way))));
  }
  for (const MeanVec& found : {along_axis, along_edge, across_cell, beside_edge, beside_cell})
    if (found.count > 0) return found.mean();
  return mean_of_box(model, state, slot_node(l, slot));
}

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
    label[n] = pieces.label[cell.places + std::size_t(place_in_cell(f, corners[n]))];
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
    return is_solid(model, state, slot) ? state.u[std::size_t(slot)] : follow_neighbours(model, state, slot);
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
