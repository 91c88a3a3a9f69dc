#include "turgor/models/lattice/cutting/fragment_stages.hpp"

#include <algorithm>
#include <bit>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"

namespace turgor::lattice {

namespace {

/// Hash of the first cut edges. It is taken for every cut, and so mixes words instead of bytes.
std::uint64_t hash_edges(const Cuts& cuts, std::size_t count) {
  std::uint64_t hash = kHashSeed;
  const auto mix = [&hash](std::uint64_t word) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 29;
  };
  for (std::size_t n = 0; n < count; n++) {
    const CutEdge& edge = cuts.edges[n];
    mix(std::uint64_t(std::uint32_t(edge.slot)) << 32 | std::uint64_t(edge.sub_index) << 16 |
        std::uint64_t(edge.family) << 9 | std::uint64_t(edge.incision) << 1 | edge.rightward);
    mix(std::uint64_t(std::bit_cast<std::uint32_t>(edge.fraction)) << 32 |
        std::bit_cast<std::uint32_t>(edge.along));
  }
  return hash;
}

/// True if the fragments can be reused: the same nodes were removed, and edges were only added.
bool can_be_reused(const Fragments& before, const Cuts& cuts, const Fragments& out) {
  const FragmentStages& then = before.stages;
  return then.edges > 0 && then.edges <= cuts.edges.size() && then.removed_nodes == cuts.removed_nodes &&
         then.excised == cuts.excised.size() && before.fine.size == out.fine.size &&
         before.fine.subdivisions == out.fine.subdivisions && then.edges_hash == hash_edges(cuts, then.edges);
}

/// Marks the cells in and around which edges or first sample lines were cut since `before`.
std::vector<std::uint8_t> changed_cells(const Cuts& cuts, const Fragments& out, const Fragments& before) {
  const FineLattice& f = out.fine;
  // cells of new edges
  std::vector<std::uint8_t> cut(out.cells.size()), changed(out.cells.size());
  for (std::size_t n = before.stages.edges; n < cuts.edges.size(); n++) {
    const Int3 a = fine_node(f, cuts.edges[n]);
    for_cells_of_edge(f, a, a + kFamilies[cuts.edges[n].family], [&](Int3 cell) {
      cut[std::size_t(out.cell_index.find(std::uint64_t(node_slot(f.cells, cell))))] = 1;
    });
  }
  // cells whose lattice edges were cut, or whose sample lines a blade crosses for the first time
  for (std::size_t c = 0; c < out.cells.size(); c++) {
    const int index = before.cell_index.find(std::uint64_t(out.cells[c].slot));
    const std::uint64_t then = index < 0 ? 0 : before.stages.corner_cuts[std::size_t(index)];
    if (then != out.stages.corner_cuts[c]) cut[c] = 1;
  }
  // and their neighbors
  for (std::size_t c = 0; c < cut.size(); c++) {
    if (!cut[c]) continue;
    const Int3 cell = slot_node(f.cells, out.cells[c].slot);
    const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
               high = min(cell + Int3{1, 1, 1}, f.cells.size - Int3{2, 2, 2});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (const int near = out.cell_index.find(std::uint64_t(node_slot(f.cells, i, j, k))); near >= 0)
            changed[std::size_t(near)] = 1;
  }
  return changed;
}

}  // namespace

std::uint64_t cuts_at_corners(const Cuts& cuts, const Lattice& lattice, int slot) {
  constexpr std::uint8_t kEdges = kCutCell - 1;
  static_assert(kCutCell == 1 << 7, "the highest bit of each corner is free");
  const auto sampled = std::uint64_t(sampled_incisions(cuts, slot));
  const int parity = slot_node(lattice, slot).x & 1;
  std::uint64_t bits = 0;
  for (int n = 0; n < 8; n++)
    bits = bits << 8 | (sampled >> n & 1) << 7 |
           (cuts.cut[std::size_t(slot + slot_offset(lattice, cell_corner(n), parity))] & kEdges);
  return bits;
}

EarlierFragments find_earlier(const Fragments* before, const Cuts& cuts, Fragments& out) {
  FragmentStages& stages = out.stages;
  stages.edges = cuts.edges.size(), stages.edges_hash = hash_edges(cuts, cuts.edges.size());
  stages.removed_nodes = cuts.removed_nodes, stages.excised = cuts.excised.size();
  for (const CutCell& cell : out.cells)
    stages.corner_cuts.push_back(cuts_at_corners(cuts, out.fine.cells, cell.slot));
  EarlierFragments earlier;
  if (before == nullptr || !can_be_reused(*before, cuts, out)) return earlier;
  // cells that exist, and in and around which nothing was cut
  earlier.fragments = before;
  const std::vector<std::uint8_t> changed = changed_cells(cuts, out, *before);
  for (std::size_t c = 0; c < out.cells.size(); c++) {
    const int index = before->cell_index.find(std::uint64_t(out.cells[c].slot));
    earlier.cell.push_back(changed[c] ? -1 : index);
  }
  return earlier;
}

void copy_cell(const Fragments& before, int index, CutCell& cell, Fragments& out) {
  const CutCell& from = before.cells[std::size_t(index)];
  TURGOR_CHECK(from.slot == cell.slot && from.is_cut == cell.is_cut, "a cell is copied from itself");
  const auto count = std::ptrdiff_t(sub_node_count(out.fine));
  const auto labels = before.stages.tissue.begin() + std::ptrdiff_t(from.first_sub_index);
  std::copy(labels, labels + count, out.label.begin() + std::ptrdiff_t(cell.first_sub_index));
  // crack tips
  cell.first_tip = int(out.tips.size()), cell.tip_count = from.tip_count;
  const auto tips = before.tips.begin() + from.first_tip;
  out.tips.insert(out.tips.end(), tips, tips + from.tip_count);
  // fragments
  cell.first_fragment = int(out.all.size()), cell.fragment_count = from.fragment_count;
  const int parity = slot_node(out.fine.cells, cell.slot).x & 1;
  for (int p = from.first_fragment; p < from.first_fragment + from.fragment_count; p++) {
    const Fragment& known = before.all[std::size_t(p)];
    Fragment fragment{.cell = int(&cell - out.cells.data()),
                      .lowest_node = known.lowest_node,
                      .thin = known.thin,
                      .corner = {}};
    for (int n = 0; n < 8; n++)
      fragment.corner[std::size_t(n)] = cell.slot + slot_offset(out.fine.cells, cell_corner(n), parity);
    out.all.push_back(fragment);
  }
}

void copy_air_labels(const Fragments& before, int index, const CutCell& cell, Fragments& out) {
  const std::size_t from = before.cells[std::size_t(index)].first_sub_index;
  for (std::size_t n = 0; n < std::size_t(sub_node_count(out.fine)); n++)
    out.label[cell.first_sub_index + n] = std::max(before.label[from + n], std::int16_t(-1));
}

}  // namespace turgor::lattice
