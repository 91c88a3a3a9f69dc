#include "turgor/models/lattice/placed_body.hpp"

#include <cmath>

namespace turgor::lattice {

namespace {

Int3 to_units(const PlacedBody& body, Int3 node, Vec3 displacement) {
  constexpr double kFarthest = 30000;  // beyond any grid [voxels]
  const Vec3d x = hadamard(Vec3d(node), body.cut.model.grid.spacing) + Vec3d(displacement);
  const Vec3d at = min(max(body.out_origin + body.to_out * x, Vec3d{-kFarthest, -kFarthest, -kFarthest}),
                       Vec3d{kFarthest, kFarthest, kFarthest}) *
                   double(1 << body.window.bits);
  return {int(std::lrint(at.x)), int(std::lrint(at.y)), int(std::lrint(at.z))};
}

/// The finest fixed point in which no tetrahedron is too large for exact arithmetic: no two nodes of a cell
/// move apart by more than the range of all displacements.
int finest_bits(const PlacedBody& body) {
  const VecField& u = body.cut.state.u;
  Vec3 low, high;
  for (std::size_t s = 0; s < body.cut.solid.size(); s++)
    if (body.cut.solid[s]) low = min(low, u[s]), high = max(high, u[s]);
  const Vec3d reach = body.cut.model.grid.spacing + Vec3d(high - low) * 3.0;
  double extent = 0;
  for (int row = 0; row < 3; row++) {
    double sum = 0;
    for (int column = 0; column < 3; column++)
      sum += std::abs(body.to_out.column[column][row]) * reach[column];
    extent = std::max(extent, sum);
  }
  int bits = 10;
  while (bits > 0 && extent * double(1 << bits) >= 0.9 * kLargestExtent) bits--;
  return bits;
}

/// One layer of nodes: their places, which cells above them hold tissue, and the bounds of each row.
struct PlaceLayer {
  PlacedBody& body;
  std::vector<PlacedBody::Bounds>& node_rows;

  void operator()(std::size_t layer) const {
    const Lattice& l = body.cut.model.lattice;
    const auto& solid = body.cut.solid;
    const auto& tissue = body.cut.model.tissue;
    for (int j = 0; j < l.size.y; j++) {
      PlacedBody::Bounds& bounds = node_rows[layer * std::size_t(l.size.y) + std::size_t(j)];
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, int(layer)};
        const int slot = node_slot(l, node), parity = i & 1;
        int cell = 0;
        for (int c = 0; c < 8; c++)
          cell |= int(tissue[std::size_t(slot + slot_offset(l, {c & 1, c >> 1 & 1, c >> 2}, parity))]);
        const bool inside = i + 1 < l.size.x && j + 1 < l.size.y && int(layer) + 1 < l.size.z;
        body.cells[std::size_t(slot)] = cell != 0 && inside ? Cell::kPlain : Cell::kEmpty;

        Vec3 u = body.cut.state.u[std::size_t(slot)];
        if (!solid[std::size_t(slot)] && !follow_neighbours(slot, parity, u)) continue;
        const Int3 place = to_units(body, node, u);
        body.place[std::size_t(slot)] = place;
        bounds.low = std::min(bounds.low, place.z), bounds.high = std::max(bounds.high, place.z);
      }
    }
  }

  /// What the tissue beside an air node suggests for its displacement, on average, as ghost_displacement()
  /// does near cuts; false without tissue.
  bool follow_neighbours(int slot, int parity, Vec3& u) const {
    const Lattice& l = body.cut.model.lattice;
    const VecField& field = body.cut.state.u;
    Vec3 sum;
    int count = 0;
    for (const Int3 offset : kFamilies)
      for (const Int3 way : {offset, -offset}) {
        const int beside = slot + slot_offset(l, way, parity);
        if (!body.cut.solid[std::size_t(beside)]) continue;
        const int behind = beside + slot_offset(l, way, (parity + way.x) & 1);
        const Vec3 here = field[std::size_t(beside)];
        sum += body.cut.solid[std::size_t(behind)] ? here * Real(2) - field[std::size_t(behind)] : here;
        count++;
      }
    if (count > 0) u = sum / Real(count);
    return count > 0;
  }
};

template <class Do>
void for_box(const Lattice& l, Int3 low, Int3 high, const Do& act) {
  low = max(low, Int3{0, 0, 0}), high = min(high, l.size - Int3{1, 1, 1});
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) act(std::size_t(node_slot(l, i, j, k)));
}

/// Near a cut, every cell that touches a node beside a cut edge is special; so are the cells of removed
/// nodes.
void mark_special(PlacedBody& body) {
  const Lattice& l = body.cut.model.lattice;
  const auto make_special = [&](std::size_t slot) {
    if (body.cells[slot] == Cell::kPlain) body.cells[slot] = Cell::kSpecial;
  };
  constexpr Int3 one{1, 1, 1};
  for (const CutEdge& edge : body.cut.state.cut_edges) {
    const Int3 a = slot_node(l, edge.slot), b = a + kFamilies[edge.family];
    for_box(l, a - one, b + one, [&](std::size_t slot) { body.near_cut[slot] = 1; });
    for_box(l, a - one - one, b + one, make_special);
  }
  for (std::size_t s = 0; s < body.cut.solid.size(); s++)
    if (!body.cut.solid[s] && is_body(body.cut.model.tissue[s])) {
      const Int3 node = slot_node(l, int(s));
      for_box(l, node - one, node, make_special);
    }
}

/// Rows of cells from rows of nodes. Ghosts beside a cut may reach as far as the neighbours of the row's
/// nodes, and one step more.
void bound_rows(PlacedBody& body, const std::vector<PlacedBody::Bounds>& node_rows) {
  const Lattice& l = body.cut.model.lattice;
  const Vec3d step = body.cut.model.grid.spacing;
  double along_k = 0;
  for (int axis = 0; axis < 3; axis++) along_k += std::abs(body.to_out.column[axis].z) * step[axis];
  const int margin = int(std::ceil(along_k * double(1 << body.window.bits)));
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++) {
      bool special = false;
      const int slot = row_slot(l, j, k);
      for (int n = 0; n < row_stride(l); n++) special |= body.cells[std::size_t(slot + n)] == Cell::kSpecial;
      const int reach = special ? 1 : 0;
      PlacedBody::Bounds bounds;
      for (int nk = std::max(0, k - reach); nk <= std::min(l.size.z - 1, k + 1 + reach); nk++)
        for (int nj = std::max(0, j - reach); nj <= std::min(l.size.y - 1, j + 1 + reach); nj++) {
          const PlacedBody::Bounds& row =
              node_rows[std::size_t(nk) * std::size_t(l.size.y) + std::size_t(nj)];
          bounds.low = std::min(bounds.low, row.low), bounds.high = std::max(bounds.high, row.high);
        }
      if (special) bounds.low -= margin, bounds.high += margin;
      body.rows[std::size_t(k) * std::size_t(l.size.y - 1) + std::size_t(j)] = bounds;
    }
}

}  // namespace

PlacedBody place_body(const Exec& exec, const Model& model, const State& state, const Grid& out) {
  PlacedBody body{.cut = make_cut_body(model, state),
                  .out = out,
                  .window = {.low = {0, 0, 0}, .high = out.size},
                  .to_out = inverse(out.axes) * model.grid.axes,
                  .out_origin = index_at(out, model.grid.origin),
                  .place = {},
                  .cells = {},
                  .near_cut = {},
                  .rows = {}};
  for (Vec3d& column : body.to_out.column)
    column = {column.x / out.spacing.x, column.y / out.spacing.y, column.z / out.spacing.z};
  body.window.handed = determinant(body.to_out) < 0 ? -1 : 1;
  body.window.bits = finest_bits(body);

  const Lattice& l = model.lattice;
  const std::size_t slots = model.tissue.size();
  body.place.resize(slots);
  body.cells.resize(slots);
  body.near_cut.resize(slots);
  std::vector<PlacedBody::Bounds> node_rows(std::size_t(l.size.y) * std::size_t(l.size.z));
  parallel_for(exec, std::size_t(l.size.z), PlaceLayer{body, node_rows});
  mark_special(body);
  body.rows.resize(std::size_t(l.size.y - 1) * std::size_t(l.size.z - 1));
  bound_rows(body, node_rows);
  return body;
}

namespace detail {

std::array<Int3, 4> side_places(const PlacedBody& body, const TetNodes& nodes, const TetSides& sides,
                                int side) {
  std::size_t own = 0;
  while (sides.side[own] != side) own++;
  std::array<Int3, 4> place;
  for (std::size_t n = 0; n < 4; n++) {
    const auto slot = std::size_t(node_slot(body.cut.model.lattice, nodes[n]));
    const bool ghost = sides.side[n] >= 0 ? sides.side[n] != side : body.near_cut[slot] != 0;
    place[n] = ghost ? to_units(body, nodes[n], ghost_displacement(body.cut, nodes[n], nodes[own]))
                     : body.place[slot];
  }
  return place;
}

}  // namespace detail
}  // namespace turgor::lattice
