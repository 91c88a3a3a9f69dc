#include "turgor/models/lattice/cutting/air_labels.hpp"

#include <algorithm>
#include <span>

namespace turgor::lattice {

void label_air(const CellSubLattice& sub_lattice) {
  const std::span labels(sub_lattice.label, std::size_t(sub_node_count(sub_lattice.fine)));
  if (std::none_of(labels.begin(), labels.end(), [](std::int16_t label) { return label < 0; })) return;
  // breadth-first search from all labeled nodes
  std::vector<Int3> open;
  for_sub_nodes(sub_lattice.fine, [&](Int3 p) {
    if (sub_lattice.label[sub_index(sub_lattice.fine, p)] >= 0) open.push_back(p);
  });
  for (std::size_t next = 0; next < open.size(); next++) {
    const Int3 p = open[next];
    const std::int16_t label = sub_lattice.label[sub_index(sub_lattice.fine, p)];
    sub_lattice.for_connected(p, [&](Int3 neighbor, int sub_node) {
      if (sub_lattice.label[sub_node] >= 0) return;
      sub_lattice.label[sub_node] = label;
      open.push_back(neighbor);
    });
  }
}

void find_ghosts(Fragments& out, CutCell& cell) {
  const FineLattice& f = out.fine;
  const CellSubLattice sub_lattice(out, cell);
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
  cell.first_ghost = int(out.ghosts.size());
  // seeds on the border
  std::vector<std::pair<Int3, std::int16_t>> found;
  for_sub_nodes(f, [&](Int3 p) {
    if (sub_lattice.label[sub_index(f, p)] != -1) return;
    GhostFragment ghost{.slot = cell.slot, .cell = -1};
    for_cells_of_edge(f, first + p, first + p, [&](Int3 neighbor) {
      const int other = out.cell_index.find(std::uint64_t(node_slot(f.cells, neighbor)));
      if (other < 0 || ghost.cell >= 0) return;
      const std::size_t index = out.cells[std::size_t(other)].first_sub_index +
                                std::size_t(sub_index(f, first + p - first_of_cell(f, neighbor)));
      if (out.label[index] >= 0) ghost.cell = other, ghost.fragment = out.label[index];
    });
    if (ghost.cell < 0) return;
    // one ghost per fragment of a neighboring cell
    const auto existing =
        std::find_if(out.ghosts.begin() + cell.first_ghost, out.ghosts.end(),
                     [&](GhostFragment g) { return g.cell == ghost.cell && g.fragment == ghost.fragment; });
    found.emplace_back(p, std::int16_t(-2 - (existing - out.ghosts.begin() - cell.first_ghost)));
    if (existing == out.ghosts.end()) out.ghosts.push_back(ghost);
  });
  for (const auto& [p, label] : found) sub_lattice.label[sub_index(f, p)] = label;
  // spread along uncut edges
  for (std::size_t next = 0; next < found.size(); next++) {
    const std::int16_t label = found[next].second;
    sub_lattice.for_connected(Int3(found[next].first), [&](Int3 neighbor, int sub_node) {
      if (sub_lattice.label[sub_node] != -1) return;
      sub_lattice.label[sub_node] = label;
      found.emplace_back(neighbor, label);
    });
  }
  cell.ghost_count = int(out.ghosts.size()) - cell.first_ghost;
}

}  // namespace turgor::lattice
