#include "turgor/models/lattice/resample/deformed_body.hpp"

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// Finest fixed point for the tissue's displacements.
int finest_bits_of(const DeformedBody& body) {
  const VecField& u = body.state.motion.u;
  Vec3 low, high;
  for (std::size_t s = 0; s < body.solid.size(); s++)
    if (body.solid[s]) low = min(low, u[s]), high = max(high, u[s]);
  return finest_bits(body.voxel_coordinates, low, high);
}

/// Processes one layer of nodes: positions, cells above them that hold tissue, bounds of each row.
struct LocateLayer {
  DeformedBody& body;
  std::vector<DeformedBody::Bounds>& node_rows;

  void operator()(std::size_t layer) const {
    const Lattice& l = body.model.anatomy.lattice;
    const auto& tissue = body.model.anatomy.tissue;
    for (int j = 0; j < l.size.y; j++) {
      DeformedBody::Bounds& bounds = node_rows[layer * std::size_t(l.size.y) + std::size_t(j)];
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, int(layer)};
        const int slot = node_slot(l, node), parity = i & 1;
        // cells with tissue at rest
        int cell = 0;
        for (int c = 0; c < 8; c++)
          cell |= int(tissue[std::size_t(slot + slot_offset(l, cell_corner(c), parity))]);
        const bool inside = i + 1 < l.size.x && j + 1 < l.size.y && int(layer) + 1 < l.size.z;
        body.cells[std::size_t(slot)] = cell != 0 && inside ? Cell::kPlain : Cell::kEmpty;

        // positions of tissue and adjacent air
        if (!body.is_solid(slot) && !is_beside_tissue(l, body, slot, parity)) continue;
        const Vec3 u = corner_displacement(body.model, body.state, body.fragments, slot);
        const Int3 position = body.voxel_coordinates(node, u);
        body.position[std::size_t(slot)] = position;
        bounds.low = std::min(bounds.low, position.z), bounds.high = std::max(bounds.high, position.z);
      }
    }
  }
};

/// Extends the bounds of rows by virtual nodes and ghost corners, which may lie beyond the nodes.
void bound_virtual_nodes(DeformedBody& body) {
  const int slots = slot_count(body.model.anatomy.lattice);
  // virtual nodes of fragments
  for (const Fragment& fragment : body.fragments.all) {
    const Int3 cell =
        slot_node(body.model.anatomy.lattice, body.fragments.cells[std::size_t(fragment.cell)].slot);
    DeformedBody::Bounds& row =
        body.rows[std::size_t(cell.z) * std::size_t(body.model.anatomy.lattice.size.y - 1) +
                  std::size_t(cell.y)];
    for (const int corner : fragment.corner)
      if (const int z = body.position[std::size_t(corner)].z; corner >= slots)
        row.low = std::min(row.low, z), row.high = std::max(row.high, z);
  }
  // corners of ghosts
  for (std::size_t g = 0; g < body.fragments.ghosts.size(); g++) {
    const Int3 cell = slot_node(body.model.anatomy.lattice, body.fragments.ghosts[g].slot);
    DeformedBody::Bounds& row =
        body.rows[std::size_t(cell.z) * std::size_t(body.model.anatomy.lattice.size.y - 1) +
                  std::size_t(cell.y)];
    for (std::size_t c = 0; c < 8; c++) {
      const int z = body.position[std::size_t(slots) + body.fragments.virtual_nodes.size() + 8 * g + c].z;
      row.low = std::min(row.low, z), row.high = std::max(row.high, z);
    }
  }
}

/// Bounds of rows of cells from those of rows of nodes.
void bound_rows(DeformedBody& body, const std::vector<DeformedBody::Bounds>& node_rows) {
  const Lattice& l = body.model.anatomy.lattice;
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++) {
      DeformedBody::Bounds bounds;
      for (int nk = k; nk <= k + 1; nk++)
        for (int nj = j; nj <= j + 1; nj++) {
          const DeformedBody::Bounds& row =
              node_rows[std::size_t(nk) * std::size_t(l.size.y) + std::size_t(nj)];
          bounds.low = std::min(bounds.low, row.low), bounds.high = std::max(bounds.high, row.high);
        }
      body.rows[std::size_t(k) * std::size_t(l.size.y - 1) + std::size_t(j)] = bounds;
    }
}

}  // namespace

DeformedBody deform_body(const Exec& exec, const Model& model, const State& state, const Grid& out) {
  DeformedBody body{.model = model,
                    .state = state,
                    .fragments = *fragments_of(model, state.cuts),
                    .solid = {},
                    .out = out,
                    .window = {.low = {0, 0, 0}, .high = out.size},
                    .voxel_coordinates = voxel_coordinates(model, out),
                    .position = {},
                    .cells = {},
                    .rows = {}};
  // tissue and fixed point
  body.solid.resize(model.anatomy.tissue.size());
  for (std::size_t s = 0; s < body.solid.size(); s++)
    body.solid[s] = has_displacement(model, state.cuts, int(s));
  body.window.handedness = handedness(body.voxel_coordinates);
  body.window.bits = body.voxel_coordinates.bits = finest_bits_of(body);

  TURGOR_CHECK(state.motion.u.x.size() == model.anatomy.tissue.size(),
               "positions are on the host while the body is resampled");
  const Lattice& l = model.anatomy.lattice;
  const std::size_t slots = model.anatomy.tissue.size();
  // positions of nodes, virtual nodes and ghost corners
  const std::size_t ghosts = body.fragments.ghosts.size();
  body.position.resize(std::size_t(slot_count(l)) + body.fragments.virtual_nodes.size() + 8 * ghosts);
  body.cells.resize(slots);
  std::vector<DeformedBody::Bounds> node_rows(std::size_t(l.size.y) * std::size_t(l.size.z));
  parallel_for(exec, std::size_t(l.size.z), LocateLayer{body, node_rows});
  for (std::size_t c = 0; c < body.fragments.virtual_nodes.size(); c++) {
    const int corner = slot_count(l) + int(c);
    body.position[std::size_t(corner)] =
        body.voxel_coordinates(slot_node(l, body.fragments.virtual_nodes[c].slot),
                               corner_displacement(model, state, body.fragments, corner));
  }
  Int3* ghost_position = body.position.data() + slot_count(l) + body.fragments.virtual_nodes.size();
  for (std::size_t n = 0; n < 8 * ghosts; n++) {
    const int c = int(n % 8);
    ghost_position[n] =
        body.voxel_coordinates(slot_node(l, body.fragments.ghosts[n / 8].slot) + cell_corner(c),
                               ghost_displacement(model, state, body.fragments, int(n / 8), c));
  }
  // special cells and bounds
  for (const SpecialCell& special : special_cells(model, state.cuts, body.fragments))
    if (Cell& cell = body.cells[std::size_t(special.slot)]; cell == Cell::kPlain) cell = Cell::kSpecial;
  body.rows.resize(std::size_t(l.size.y - 1) * std::size_t(l.size.z - 1));
  bound_rows(body, node_rows);
  bound_virtual_nodes(body);
  return body;
}

}  // namespace turgor::lattice
