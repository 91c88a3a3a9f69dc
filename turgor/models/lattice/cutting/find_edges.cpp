// Search for the edges that a blade will cut, at current positions of the body.
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// Largest squared displacement of the body's nodes [m²].
Real largest_squared_displacement(const Model& model, const Motion& motion, const HaloExchange* halo) {
  TURGOR_CHECK(motion.u.x.size() == model.anatomy.tissue.size(),
               "positions are on the host while edges are found");
  Real farthest = 0;
  for (int s = row_slot(model.anatomy.lattice, -1, model.anatomy.owned.begin);
       s < row_slot(model.anatomy.lattice, -1, model.anatomy.owned.end); s++)
    if (const auto n = std::size_t(s); has_node(model, s))
      farthest = std::max(farthest, dot(motion.u[n], motion.u[n]));
  return halo ? std::bit_cast<Real>(halo->largest(std::bit_cast<std::uint32_t>(farthest))) : farthest;
}

/// Range of owned nodes and cells that may be near the sheet. `reach` is the largest displacement [m].
struct Range {
  Int3 low, high;
};
Range range_near(const Model& model, const BladeSheet& sheet, double reach) {
  Range range{};
  for (int axis = 0; axis < 3; axis++) {
    const double step = double(model.anatomy.lattice.spacing[axis]);
    range.low[axis] = std::max(0, int(std::floor((sheet.box.low[axis] - reach) / step)) - 2);
    range.high[axis] = int(std::ceil((sheet.box.high[axis] + reach) / step)) + 2;
  }
  // restrict to the owned layers of this process
  range.low.z -= model.anatomy.lattice.first, range.high.z -= model.anatomy.lattice.first;
  range.low.z = std::max(range.low.z, model.anatomy.owned.begin),
  range.high.z = std::min(range.high.z, model.anatomy.owned.end - 1);
  return range;
}

template <class Visit>
void for_range(const Range& range, Int3 last, Visit&& visit) {
  for (int k = range.low.z; k <= std::min(range.high.z, last.z); k++)
    for (int j = range.low.y; j <= std::min(range.high.y, last.y); j++)
      for (int i = range.low.x; i <= std::min(range.high.x, last.x); i++) visit(Int3{i, j, k});
}

Box box_of(Vec3d a, Vec3d b) { return {min(a, b), max(a, b)}; }

/// Search among lattice edges between nodes of the body and its rim.
struct LatticeEdges {
  const Model& model;
  const State& state;
  const BladeSheet& sheet;
  std::vector<PendingEdgeCut>& found;
  std::vector<int> near;

  bool bears(int slot) const { return has_node(model, slot) && state.cuts.removed[std::size_t(slot)] == 0; }

  void operator()(Int3 node) {
    const Lattice& l = model.anatomy.lattice;
    const int slot = node_slot(l, node);
    if (!bears(slot)) return;
    // whole edges to nodes of each family
    const Vec3d a(position(model, state.motion, node));
    for (int f = 0; f < kFamilyCount; f++) {
      const Int3 other = node + kFamilies[std::size_t(f)];
      if (!contains(l, other) || state.cuts.cut[std::size_t(slot)] >> f & 1) continue;
      if (!bears(node_slot(l, other))) continue;
      const Vec3d b(position(model, state.motion, other));
      triangles_near(sheet, box_of(a, b), near);
      if (const auto hit = cross_sheet(sheet, near, a, b))
        found.push_back({slot, std::uint8_t(f), Real(hit->along)});
    }
  }
};

/// Search among edges of the fine lattice in all cells with a tissue node. Ends in air are included, because
/// edges through the skin locate the lips. An edge in a face belongs to the cell with higher indices, which
/// may be air.
struct FineEdges {
  const Model& model;
  const State& state;
  const Fragments& fragments;
  const BladeSheet& sheet;
  std::vector<CutEdge>& found;
  std::vector<PendingSampleCut>& lines;
  std::vector<int> near;
  std::array<Vec3d, kMaxSubNodes> sub_node_position;
  std::vector<std::optional<std::array<Vec3d, 8>>> known_corners;  // corner_positions by Fragments::all
  std::array<bool, 8> has_body;  // of the current cell (0) and its lower neighbors: bits x (1), y (2), z (4)

  bool is_of_body(Int3 cell) const {
    const int slot = node_slot(model.anatomy.lattice, cell);
    for (int c = 0; c < 8; c++)
      if (is_solid(model, state.cuts, slot + slot_offset(model.anatomy.lattice, cell_corner(c), cell.x & 1)))
        return true;
    return false;
  }
  /// True if one of the cells that contain an edge has tissue. The edge joins two sub-lattice nodes of the
  /// current cell.
  bool is_in_body(Int3 from, Int3 to) const {
    int faces = 0;  // bits of the lower faces of the cell that contain the edge
    for (int axis = 0; axis < 3; axis++) faces |= int(from[axis] == 0 && to[axis] == 0) << axis;
    for (int n = 0; n < 8; n++)
      if ((n & ~faces) == 0 && has_body[std::size_t(n)]) return true;
    return false;
  }

  void operator()(Int3 cell) {
    const Lattice& l = model.anatomy.lattice;
    // tissue in this cell and its lower neighbors
    bool any = false;
    for (int n = 0; n < 8; n++) {
      const Int3 below = cell_corner(n);
      has_body[std::size_t(n)] = contains(l, cell - below) && is_of_body(cell - below);
      any |= has_body[std::size_t(n)];
    }
    if (!any) return;
    // triangles of the sheet near the cell
    const CutCell* cut = find_cell(fragments, node_slot(l, cell));
    triangles_near(sheet, position_sub_nodes(cell, cut), near);
    if (near.empty()) return;
    // cut edges and sample lines
    for_sub_nodes(fragments.fine, [&](Int3 p) { add_edges(cell, cut, p); });
    const int own = own_fragments(cut);
    for (int fragment = 0; fragment < own; fragment++) add_sample_cuts(cell, cut, fragment);
  }

  /// Number of a cell's own fragments; 1 for a cell that is not near a cut.
  static int own_fragments(const CutCell* cut) { return cut ? std::max(cut->fragment_count, 1) : 1; }

  /// Current positions of the corners of a fragment. Ghosts are numbered after the cell's own fragments.
  std::array<Vec3d, 8> corner_positions(Int3 cell, const CutCell* cut, int fragment) const {
    const int own = own_fragments(cut);
    const auto corners = corners_of(model, fragments, node_slot(fragments.fine.cells, cell),
                                    cut && fragment < own ? fragment : -1);
    std::array<Vec3d, 8> x;
    for (std::size_t c = 0; c < 8; c++) {
      const Vec3 u = fragment < own ? corner_displacement(model, state, fragments, corners[c])
                                    : ghost_displacement(model, state, fragments,
                                                         cut->first_ghost + fragment - own, int(c));
      x[c] = Vec3d(rest_position(fragments.fine.cells, cell + cell_corner(int(c)))) + Vec3d(u);
    }
    return x;
  }

  void add_sample_cuts(Int3 cell, const CutCell* cut, int fragment) {
    const std::array<Vec3d, 8> x = corner_positions(cell, cut, fragment);
    // current position of a point in the fragment
    const auto position_of = [&](Vec3d at) {
      const auto weight = trilinear(at);
      Vec3d sum;
      for (std::size_t c = 0; c < 8; c++) sum += x[c] * weight[c];
      return sum;
    };
    // sample lines that the sheet crosses inside the fragment
    for (int axis = 0; axis < 3; axis++)
      for (int line = 0; line < kLines; line++) {
        Vec3d at = line_start(axis, line);
        const Vec3d from = position_of(at);
        at[axis] = 1;
        const auto hit = cross_sheet(sheet, near, from, position_of(at));
        if (!hit) continue;
        at[axis] = hit->fraction;
        if (cut && fragment_at(fragments, state.cuts, *cut, Vec3(at)) != fragment) continue;
        lines.push_back({node_slot(model.anatomy.lattice, cell), std::uint8_t(axis), std::uint8_t(line),
                         Real(hit->along)});
      }
  }

  /// Computes the current positions of all sub-lattice nodes, each from the corners of its fragment. Returns
  /// the bounding box of these corners.
  Box position_sub_nodes(Int3 cell, const CutCell* cut) {
    const FineLattice& f = fragments.fine;
    const int own = own_fragments(cut);
    const int count = own + (cut ? cut->ghost_count : 0);
    TURGOR_CHECK(count > 0, "a cell has at least one fragment");
    Box box{};
    // extend the bounding box by the fragment's corners
    for (int fragment = 0; fragment < count; fragment++) {
      const std::array<Vec3d, 8> x = corner_positions(cell, cut, fragment);
      for (std::size_t c = 0; c < 8; c++)
        box = fragment == 0 && c == 0 ? box_of(x[c], x[c]) : Box{min(box.low, x[c]), max(box.high, x[c])};
      // sub-lattice nodes of the fragment
      for_sub_nodes(f, [&](Int3 p) {
        const int at = sub_index(f, p);
        if (count > 1 && fragment_of(fragments.label.data(), *cut, at) != fragment) return;
        const auto weight = trilinear(Vec3d{double(p.x) / f.subdivisions.x, double(p.y) / f.subdivisions.y,
                                            double(p.z) / f.subdivisions.z});
        sub_node_position[std::size_t(at)] = {};
        for (std::size_t c = 0; c < 8; c++) sub_node_position[std::size_t(at)] += x[c] * weight[c];
      });
    }
    if (cut) average_border(cell, *cut);
    return box;
  }

  /// Moves sub-lattice nodes on the border of a cell to the mean of their positions in all cells that contain
  /// them. These differ where a blade ends (virtual_nodes.hpp), and a later blade would miss edges there.
  void average_border(Int3 cell, const CutCell& cut) {
    const FineLattice& f = fragments.fine;
    const Int3 first = first_of_cell(f, cell);
    for_sub_nodes(f, [&](Int3 p) {
      const auto at = std::size_t(sub_index(f, p));
      const bool is_inside = p.x > 0 && p.y > 0 && p.z > 0 && p.x < f.subdivisions.x &&
                             p.y < f.subdivisions.y && p.z < f.subdivisions.z;
      if (is_inside || fragments.label[cut.first_sub_index + at] < 0) return;
      Vec3d sum;
      int count = 0;
      for_cells_of_edge(f, first + p, first + p, [&](Int3 other) {
        const CutCell* near_cell = find_cell(fragments, node_slot(f.cells, other));
        if (near_cell == nullptr) return;
        const Int3 local = first + p - first_of_cell(f, other);
        const int fragment = fragments.label[near_cell->first_sub_index + std::size_t(sub_index(f, local))];
        if (fragment < 0) return;
        // corners of this fragment
        auto& x = known_corners[std::size_t(near_cell->first_fragment + fragment)];
        if (!x) x = corner_positions(other, near_cell, fragment);
        const auto weight =
            trilinear(Vec3d{double(local.x) / f.subdivisions.x, double(local.y) / f.subdivisions.y,
                            double(local.z) / f.subdivisions.z});
        for (std::size_t c = 0; c < 8; c++) sum += (*x)[c] * weight[c];
        count++;
      });
      if (count > 1) sub_node_position[at] = sum / double(count);
    });
  }

  /// Finds cut fine edges that start at a sub-lattice node. In a cell with a crack tip, the ends of an edge
  /// may belong to two fragments with a wound between them. A blade that passes through this wound cuts the
  /// edge too.
  void add_edges(Int3 cell, const CutCell* cut, Int3 local) {
    const FineLattice& f = fragments.fine;
    const Int3 node = first_of_cell(f, cell) + local;
    if (!(cell_of(f, node) == cell)) return;  // belongs to another cell
    const int at = sub_index(f, local);
    // uncut edges of each family with tissue in an adjacent cell
    for (int n = 0; n < kFamilyCount; n++) {
      const Int3 other = local + kFamilies[std::size_t(n)];
      if (!in_cell(f, other) || !is_in_body(local, other)) continue;
      if (cut && fragments.cut_bits[cut->first_sub_index + std::size_t(at)] >> n & 1) continue;
      const auto hit = cross_sheet(sheet, near, sub_node_position[std::size_t(at)],
                                   sub_node_position[std::size_t(sub_index(f, other))]);
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
  const Range range =
      range_near(model, sheet, std::sqrt(double(largest_squared_displacement(model, state.motion, halo))));
  // lattice edges
  const Int3 last = model.anatomy.lattice.size - Int3{1, 1, 1};
  LatticeEdges edges{model, state, sheet, path.edges, {}};
  for_range(range, last, edges);
  // fine edges and sample lines
  const std::shared_ptr<const Fragments> fragments = fragments_of(model, state.cuts);
  FineEdges fine{model, state, *fragments, sheet, path.fine_edges, path.lines, {}, {}, {}, {}};
  fine.known_corners.resize(fragments->all.size());
  for_range(range, last - Int3{1, 1, 1}, fine);
  if (halo) halo->join_edges(path);
}

}  // namespace turgor::lattice
