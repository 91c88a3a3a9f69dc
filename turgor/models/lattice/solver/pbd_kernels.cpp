#include "turgor/models/lattice/solver/pbd_kernels.hpp"

#include <bit>
#include <map>
#include <unordered_map>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"

namespace turgor::lattice {

namespace {

/// Links the skin triangles of each cell in a group. The group is ordered in rounds (order_in_rounds):
/// triangle c of a round is in the same cell as triangle c of the next round.
void add_skin_cells(const Model& model, int group, PbdOrdering& ordering) {
  const Skin& skin = model.anatomy.skin;
  const auto cell = [&](int t) {
    return node_slot(model.anatomy.lattice,
                     cell_of(model.anatomy.lattice, skin.triangles[std::size_t(t)].vertex));
  };
  const int first = skin.batch_begin[std::size_t(skin.layer_begin[std::size_t(group)])],
            end = skin.batch_begin[std::size_t(skin.layer_begin[std::size_t(group) + 1])];
  std::map<int, int> last;  // by cell: its last triangle so far
  for (int t = first; t < end; t++) {
    const auto [at, is_first] = last.try_emplace(cell(t), t);
    if (is_first)
      ordering.heads.push_back(t);
    else
      ordering.next[std::size_t(std::exchange(at->second, t))] = t;
  }
}

/// Collects the kinds of nodes and the kind of each node.
void find_kinds(const Model& model, PbdOrdering& ordering) {
  const std::size_t slots = model.anatomy.inverse_mass.size();
  std::unordered_map<std::uint64_t, std::uint16_t> known;
  ordering.kind.resize(slots);
  for (std::size_t s = 0; s < slots; s++) {
    const NodeKind node_kind{model.anatomy.inverse_mass[s], model.springs.root_stiffness[s]};
    const auto [at, is_new] =
        known.try_emplace(std::bit_cast<std::uint64_t>(node_kind), std::uint16_t(ordering.kinds.size()));
    if (is_new) ordering.kinds.push_back(node_kind);
    ordering.kind[s] = at->second;
  }
  TURGOR_ASSERT(ordering.kinds.size() <= 65536, "a body has at most 65536 kinds of nodes");
}

}  // namespace

CellTet cell_tet(const Lattice& l, int parity, const std::array<Int3, 4>& tet) {
  CellTet out{};
  for (std::size_t c = 0; c < 4; c++) out.offset[c] = slot_offset(l, tet[c], parity);
  const auto rest = [&](std::size_t c) { return hadamard(l.spacing, Vec3(tet[c] - tet[0])); };
  out.rest = {rest(1), rest(2), rest(3)};
  out.edge = tet_edges(tet);
  return out;
}

PbdOrdering pbd_ordering(const Model& model) {
  PbdOrdering ordering;
  find_kinds(model, ordering);
  ordering.constraint_groups_of_color =
      groups_by_colors(model.anatomy.lattice, model.pbd.constraint_runs, ordering.constraint_groups);
  ordering.next.assign(model.anatomy.skin.triangles.size(), -1);
  const int layers = model.anatomy.skin.layer_begin.empty() ? 0 : model.anatomy.lattice.size.z - 1;
  for (int color = 0; color < kColorCount; color++) {
    ordering.heads_of_color.begin[color] = int(ordering.heads.size());
    for (int k = color >> 2; k < layers; k += 2) add_skin_cells(model, 4 * k + (color & 3), ordering);
  }
  ordering.heads_of_color.begin[kColorCount] = int(ordering.heads.size());
  return ordering;
}

PbdRules pbd_rules(const Model& model) {
  const Lattice& l = model.anatomy.lattice;
  PbdRules rules{.rest_volume = model.springs.volume_scale > 0 ? model.springs.rest_volume : 0,
                 .skin_ratio = rest_area_ratio(model.params.skin),
                 .skin_amplification = Real(model.params.skin.amplification)};
  // springs
  for (std::size_t f = 0; f < kFamilyCount; f++) {
    rules.edge[f] = hadamard(l.spacing, Vec3(kFamilies[f]));
    rules.rest[f] = model.springs.rest_length[f];
  }
  // corners and tetrahedra
  for (int parity = 0; parity < 2; parity++)
    for (int c = 0; c < kCellCorners; c++)
      rules.corner_offset[parity][c] = slot_offset(l, cell_corner(c), parity);
  for (std::size_t t = 0; t < kKuhnTets.size(); t++) rules.tet[t] = cell_tet(l, 0, kKuhnTets[t]).rest;
  return rules;
}

}  // namespace turgor::lattice
