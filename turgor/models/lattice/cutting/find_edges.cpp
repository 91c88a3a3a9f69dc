// The edges of a body that a blade will cut: each lies where the body has it now.
#include <algorithm>
#include <bit>
#include <cmath>

#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// Square of how far a node of the body has moved at most [m²].
Real farthest_way(const Model& model, const State& state, const HaloExchange* halo) {
  Real farthest = 0;
  for (int s = row_slot(model.lattice, -1, model.owned.begin);
       s < row_slot(model.lattice, -1, model.owned.end); s++)
    if (const auto n = std::size_t(s); is_body(model.tissue[n]))
      farthest = std::max(farthest, dot(state.u[n], state.u[n]));
  return halo ? std::bit_cast<Real>(halo->largest(std::bit_cast<std::uint32_t>(farthest))) : farthest;
}

/// Own cells and nodes that may lie near the sheet, by where they can have moved to.
struct Range {
  Int3 low, high;
};
Range range_near(const Model& model, const BladeSheet& sheet, double reach) {
  Range range{};
  for (int axis = 0; axis < 3; axis++) {
    const double step = double(model.lattice.step[axis]);
    range.low[axis] = std::max(0, int(std::floor((sheet.box.low[axis] - reach) / step)) - 2);
    range.high[axis] = int(std::ceil((sheet.box.high[axis] + reach) / step)) + 2;
  }
  range.low.z -= model.lattice.first, range.high.z -= model.lattice.first;
  range.low.z = std::max(range.low.z, model.owned.begin),
  range.high.z = std::min(range.high.z, model.owned.end - 1);
  return range;
}

template <class Visit>
void for_range(const Range& range, Int3 last, Visit&& visit) {
  for (int k = range.low.z; k <= std::min(range.high.z, last.z); k++)
    for (int j = range.low.y; j <= std::min(range.high.y, last.y); j++)
      for (int i = range.low.x; i <= std::min(range.high.x, last.x); i++) visit(Int3{i, j, k});
}

Box box_of(Vec3d a, Vec3d b) { return {min(a, b), max(a, b)}; }

/// Edges between nodes of the body.
struct LatticeEdges {
  const Model& model;
  const State& state;
  const BladeSheet& sheet;
  std::vector<PendingEdgeCut>& found;
  std::vector<int> near;

  void operator()(Int3 node) {
    const Lattice& l = model.lattice;
    const int slot = node_slot(l, node);
    if (!is_solid(model, state, slot)) return;
    const Vec3d a(position(model, state, node));
    for (int f = 0; f < kFamilyCount; f++) {
      const Int3 other = node + kFamilies[std::size_t(f)];
      if (!contains(l, other) || state.cut[std::size_t(slot)] >> f & 1) continue;
      if (!is_solid(model, state, node_slot(l, other))) continue;
      const Vec3d b(position(model, state, other));
      triangles_near(sheet, box_of(a, b), near);
      if (const auto hit = cross_sheet(sheet, near, a, b))
        found.push_back({slot, std::uint8_t(f), Real(hit->along)});
    }
  }
};

/// Edges of the fine lattice in all cells that have a node of the body: those through the skin say where lips
/// are. One in a face between two cells is counted to the higher one, which may be air.
struct FineEdges {
  const Model& model;
  const State& state;
  const Fragments& pieces;
  const BladeSheet& sheet;
  std::vector<CutEdge>& found;
  std::vector<PendingSampleCut>& lines;
  std::vector<int> near;
  std::array<Vec3d, kMostPlaces> place;
  std::array<bool, 8> has_body;  // of the cell in hand, and of those below it along x (1), y (2), z (4)

  bool is_of_body(Int3 cell) const {
    const int slot = node_slot(model.lattice, cell);
    for (int c = 0; c < 8; c++)
      if (is_solid(model, state, slot + slot_offset(model.lattice, cell_corner(c), cell.x & 1))) return true;
    return false;
  }
  /// Is a cell that has an edge between these places of the one in hand of the body?
  bool is_in_body(Int3 from, Int3 to) const {
    int faces = 0;  // lower faces of the cell that the edge lies in
    for (int axis = 0; axis < 3; axis++) faces |= int(from[axis] == 0 && to[axis] == 0) << axis;
    for (int n = 0; n < 8; n++)
      if ((n & ~faces) == 0 && has_body[std::size_t(n)]) return true;
    return false;
  }

  void operator()(Int3 cell) {
    const Lattice& l = model.lattice;
    bool any = false;
    for (int n = 0; n < 8; n++) {
      const Int3 below = cell_corner(n);
      has_body[std::size_t(n)] = contains(l, cell - below) && is_of_body(cell - below);
      any |= has_body[std::size_t(n)];
    }
    if (!any) return;
    const CutCell* cut = find_cell(pieces, node_slot(l, cell));
    triangles_near(sheet, put_places(cell, cut), near);
    if (near.empty()) return;
    for_places(pieces.fine, [&](Int3 p) { add_edges(cell, cut, p); });
    const int own = own_pieces(cut);
    for (int piece = 0; piece < own; piece++) add_lines(cell, cut, piece);
  }

  /// A cell that is not near a cut is a piece, too.
  static int own_pieces(const CutCell* cut) { return cut ? std::max(cut->fragment_count, 1) : 1; }

  /// Where the corners of a piece of a cell are now, or those of a guest after its own.
  std::array<Vec3d, 8> corner_places(Int3 cell, const CutCell* cut, int piece) const {
    const int own = own_pieces(cut);
    const auto corners =
        corners_of(model, pieces, node_slot(pieces.fine.cells, cell), cut && piece < own ? piece : -1);
    std::array<Vec3d, 8> x;
    for (std::size_t c = 0; c < 8; c++) {
      const Vec3 u = piece < own
                         ? corner_displacement(model, state, pieces, corners[c])
                         : ghost_displacement(model, state, pieces, cut->first_ghost + piece - own, int(c));
      x[c] = Vec3d(rest_position(pieces.fine.cells, cell + cell_corner(int(c)))) + Vec3d(u);
    }
    return x;
  }

  void add_lines(Int3 cell, const CutCell* cut, int piece) {
    const std::array<Vec3d, 8> x = corner_places(cell, cut, piece);
    const auto place_of = [&](Vec3d at) {
      const auto weight = trilinear(at);
      Vec3d sum;
      for (std::size_t c = 0; c < 8; c++) sum += x[c] * weight[c];
      return sum;
    };
    for (int axis = 0; axis < 3; axis++)
      for (int line = 0; line < kLines; line++) {
        Vec3d at = line_start(axis, line);
        const Vec3d from = place_of(at);
        at[axis] = 1;
        const auto hit = cross_sheet(sheet, near, from, place_of(at));
        if (!hit) continue;
        at[axis] = hit->fraction;
        if (cut && fragment_at(pieces, state, *cut, Vec3(at)) != piece) continue;
        lines.push_back(
            {node_slot(model.lattice, cell), std::uint8_t(axis), std::uint8_t(line), Real(hit->along)});
      }
  }

  /// Where all places of a cell are now, each in its own piece; returns the box around them.
  Box put_places(Int3 cell, const CutCell* cut) {
    const FineLattice& f = pieces.fine;
    const int own = own_pieces(cut);
    const int count = own + (cut ? cut->ghost_count : 0);
    Box box{};
    for (int piece = 0; piece < count; piece++) {
      const std::array<Vec3d, 8> x = corner_places(cell, cut, piece);
      for (std::size_t c = 0; c < 8; c++)
        box = piece == 0 && c == 0 ? box_of(x[c], x[c]) : Box{min(box.low, x[c]), max(box.high, x[c])};
      for_places(f, [&](Int3 p) {
        const int at = place_in_cell(f, p);
        if (count > 1 && piece_of(pieces.label.data(), *cut, at) != piece) return;
        const auto weight =
            trilinear(Vec3d{double(p.x) / f.parts.x, double(p.y) / f.parts.y, double(p.z) / f.parts.z});
        place[std::size_t(at)] = {};
        for (std::size_t c = 0; c < 8; c++) place[std::size_t(at)] += x[c] * weight[c];
      });
    }
    return box;
  }

  /// In a cell that a blade entered and did not part, the ends of an edge may be of two pieces: what goes
  /// through the wound between them cuts it.
  void add_edges(Int3 cell, const CutCell* cut, Int3 local) {
    const FineLattice& f = pieces.fine;
    const Int3 node = first_of_cell(f, cell) + local;
    if (!(cell_of(f, node) == cell)) return;  // counted to another one
    const int at = place_in_cell(f, local);
    for (int n = 0; n < kFamilyCount; n++) {
      const Int3 other = local + kFamilies[std::size_t(n)];
      if (!in_cell(f, other) || !is_in_body(local, other)) continue;
      if (cut && pieces.cut[cut->places + std::size_t(at)] >> n & 1) continue;
      const auto hit =
          cross_sheet(sheet, near, place[std::size_t(at)], place[std::size_t(place_in_cell(f, other))]);
      if (!hit) continue;
      CutEdge edge = cut_edge_at(f, node, n);
      edge.rightward = hit->rightward, edge.fraction = Real(hit->fraction), edge.along = Real(hit->along);
      found.push_back(edge);
    }
  }
};

}  // namespace

void find_edges(const Model& model, const State& state, const BladeSheet& sheet, const HaloExchange* halo,
                BladePath& path) {
  if (sheet.triangles.empty()) return;
  const Range range = range_near(model, sheet, std::sqrt(double(farthest_way(model, state, halo))));
  const Int3 last = model.lattice.size - Int3{1, 1, 1};
  LatticeEdges edges{model, state, sheet, path.edges, {}};
  for_range(range, last, edges);
  const Fragments pieces = make_fragments(model, state);
  FineEdges fine{model, state, pieces, sheet, path.fine_edges, path.lines, {}, {}, {}};
  for_range(range, last - Int3{1, 1, 1}, fine);
  if (halo) halo->join_edges(path);
}

}  // namespace turgor::lattice
