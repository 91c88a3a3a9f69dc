#include "turgor/models/lattice/surface/surface_cache.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr std::uint64_t kNoCuts = 0;  // MeshedCell::cuts of a cell that is not near a blade

Int3 cell_of_index(const Lattice& l, int index) {
  return {index % l.size.x, index / l.size.x % l.size.y, index / l.size.x / l.size.y};
}

/// Hash of the tissue that was removed or excised. The uncut surface depends on it, and not on rim nodes that
/// a cut has loosened, which were no tissue: those change with nearly every step of a blade.
std::uint64_t hash_removed_tissue(const Model& model, const Cuts& cuts) {
  std::vector<int> removed;
  for (std::size_t slot = 0; slot < cuts.removed.size(); slot++)
    if (cuts.removed[slot] == kExcised || is_removed_tissue(model, cuts, int(slot)))
      removed.push_back(4 * int(slot) + cuts.removed[slot]);
  return hash_values(std::span<const int>(removed), hash_values(std::span(cuts.excised)));
}

/// Meshes the whole body as if no blade had cut it.
UncutSurface make_uncut(const Exec& exec, const MeshInput& input) {
  Fragments none;
  none.fine = input.fragments.fine;
  const MeshInput uncut{input.model, input.cuts, input.level, none};
  const Points points = mesh_body(exec, uncut);

  // merged points: means per box
  UncutSurface made;
  std::vector<int> vertex;
  std::vector<Vec3d> sum;
  std::vector<int> count;
  for (const SurfacePoint& point : points.all) {
    const int v = made.boxes.find_or_add(merge_key(input.model, point));
    if (std::size_t(v) == sum.size()) sum.push_back({}), count.push_back(0);
    sum[std::size_t(v)] += point.position, count[std::size_t(v)]++;
    vertex.push_back(v);
  }
  made.merged.vertices.resize(sum.size());
  parallel_for(exec, sum.size(), [&](std::size_t v) {
    made.merged.vertices[v] = merged_vertex(uncut, sum[v] / double(count[v]));
  });

  // triangles that are not degenerate
  const auto at = [&vertex](int point) { return vertex[std::size_t(point)]; };
  for (std::size_t group = 0; group < kSurfaceGroups; group++)
    for (const auto& [t, cell] : points.triangles[group])
      if (const Int3 v{at(t.x), at(t.y), at(t.z)}; v.x != v.y && v.y != v.z && v.z != v.x)
        made.merged.triangles[group].push_back({v, cell});
  return made;
}

/// Calls visit(cell) for all cells whose mesh depends on a cut fine edge: those with both ends at most one
/// fine node outside (cut_points_near).
template <class Visit>
void for_cells_around_edge(const FineLattice& f, Int3 a, Int3 b, const Visit& visit) {
  Int3 low, high;
  for (int axis = 0; axis < 3; axis++) {
    const int subdivisions = f.subdivisions[axis];
    low[axis] = std::max(0, (std::max(a[axis], b[axis]) + subdivisions - 2) / subdivisions - 1);
    high[axis] = std::min(f.cells.size[axis] - 2, (std::min(a[axis], b[axis]) + 1) / subdivisions);
  }
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) visit(Int3{i, j, k});
}

/// Hash of all cuts that the mesh of each cut cell depends on: labels, ghosts, and the cut edges in and
/// around the cell.
std::vector<std::uint64_t> hash_cuts(const Fragments& fragments, const Cuts& cuts) {
  const FineLattice& f = fragments.fine;
  const auto count = std::size_t(sub_node_count(f));
  std::vector<std::uint64_t> hashes;
  // labels and ghosts
  for (const CutCell& cell : fragments.cells) {
    std::uint64_t hash = hash_values(std::span(&fragments.label[cell.first_sub_index], count),
                                     kHashSeed + std::uint64_t(cell.is_cut));
    hash = hash_values(std::span(&fragments.cut_bits[cell.first_sub_index], count), hash);
    hash = hash_values(std::span(&cell.fragment_count, 1), hash);
    for (int g = cell.first_ghost; g < cell.first_ghost + cell.ghost_count; g++) {
      const GhostFragment& ghost = fragments.ghosts[std::size_t(g)];
      const int owner[2] = {fragments.cells[std::size_t(ghost.cell)].slot, ghost.fragment};
      hash = hash_bytes(owner, sizeof owner, hash);
    }
    hashes.push_back(hash);
  }
  // cut edges
  for (const CutEdge& edge : cuts.edges) {
    const Int3 a = fine_node(f, edge);
    const std::uint64_t values[3] = {fine_edge_key(f, a, edge.family),
                                     std::uint64_t(edge.incision) * 2 + edge.rightward,
                                     std::uint64_t(std::bit_cast<std::uint32_t>(edge.fraction)) << 32 |
                                         std::bit_cast<std::uint32_t>(edge.along)};
    for_cells_around_edge(f, a, a + kFamilies[edge.family], [&](Int3 cell) {
      const int n = fragments.cell_index.find(std::uint64_t(node_slot(f.cells, cell)));
      if (n >= 0) hashes[std::size_t(n)] = hash_bytes(values, sizeof values, hashes[std::size_t(n)]);
    });
  }
  return hashes;
}

/// Cells near blades with the hashes of their cuts, and their neighbors, by ascending cell.
std::vector<std::pair<int, std::uint64_t>> cells_around(const MeshInput& input) {
  const Lattice& l = input.model.anatomy.lattice;
  const std::vector<std::uint64_t> hashes = hash_cuts(input.fragments, input.cuts);
  std::vector<std::pair<int, std::uint64_t>> cells;
  for (std::size_t n = 0; n < hashes.size(); n++) {
    const Int3 cell = slot_node(l, input.fragments.cells[n].slot);
    cells.emplace_back(cell_index(l, cell), hashes[n]);
    const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
               high = min(cell + Int3{1, 1, 1}, l.size - Int3{2, 2, 2});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (!find_cell(input.fragments, node_slot(l, i, j, k)))
            cells.emplace_back(cell_index(l, {i, j, k}), kNoCuts);
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// Meshes the cells whose cuts have changed.
void update_cells(const Exec& exec, const MeshInput& input, std::vector<MeshedCell>& near) {
  std::vector<MeshedCell> before = std::exchange(near, {});
  std::vector<std::size_t> changed;
  auto known = before.begin();
  for (const auto& [cell, cuts] : cells_around(input)) {
    while (known != before.end() && known->cell < cell) ++known;
    const bool is_kept = known != before.end() && known->cell == cell && known->cuts == cuts;
    if (!is_kept) changed.push_back(near.size());
    near.push_back(is_kept ? std::move(*known)
                           : MeshedCell{.cell = cell, .cuts = cuts, .keys = {}, .points = {}});
  }
  parallel_for(exec, changed.size(), [&](std::size_t n) {
    MeshedCell& cell = near[changed[n]];
    SlabPoints meshed = mesh_cell(input, cell_of_index(input.model.anatomy.lattice, cell.cell));
    cell.keys = std::move(meshed.keys), cell.points = std::move(meshed.points);
  });
}

/// True if a merge box touches a cell near a blade, so that points in it may not be merged any more. Box b
/// covers cell coordinates from 2 b / 3 to 2 (b + 1) / 3.
bool touches_cut(const MeshInput& input, Int3 box) {
  const Int3 last = input.model.anatomy.lattice.size - Int3{2, 2, 2};
  const auto lowest = [](int b) { return (2 * b + 2) / 3 - 1; };         // ceil(2 b / 3) - 1
  const auto highest = [](int b) { return (2 * (b + 1) + 2) / 3 - 1; };  // ceil(2 (b + 1) / 3) - 1
  const Int3 low = max(Int3{lowest(box.x), lowest(box.y), lowest(box.z)}, Int3{0, 0, 0}),
             high = min(Int3{highest(box.x), highest(box.y), highest(box.z)}, last);
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++)
        if (find_cell(input.fragments, node_slot(input.model.anatomy.lattice, i, j, k))) return true;
  return false;
}

/// Means of the boxes next to blades, without the points near cuts.
struct ChangedBoxes {
  KeyIndex index;                     // from vertex of the uncut surface
  std::vector<std::uint8_t> touches;  // by index
  std::vector<Vec3d> sum;
  std::vector<int> count, vertex;
  KeyIndex seen;  // points by key

  void add(const MeshInput& input, int v, std::uint64_t key, const SurfacePoint& point) {
    const int n = index.find_or_add(std::uint64_t(v));
    if (std::size_t(n) == touches.size()) {
      touches.push_back(touches_cut(input, merge_box(point)));
      sum.push_back({}), count.push_back(0), vertex.push_back(v);
    }
    if (!touches[std::size_t(n)]) return;
    if (const auto known = seen.size(); std::size_t(seen.find_or_add(key)) != known) return;
    sum[std::size_t(n)] += point.position, count[std::size_t(n)]++;
  }
};

/// Merged surface of the cells near blades, with the vertices of the whole body.
struct Region {
  std::vector<MergedVertex> vertices;
  std::vector<std::vector<int>> vertex;  // by cell and point
};

Region merge_region(const MeshInput& input, const SurfaceCache& cache) {
  // points near cuts are not merged
  KeyIndex separate;
  for (const MeshedCell& cell : cache.near)
    if (cell.cuts != kNoCuts)
      for (const std::uint64_t key : cell.keys) separate.find_or_add(key);
  std::vector<const SurfacePoint*> first(separate.size(), nullptr);

  // vertices of all points
  const int uncut = int(cache.uncut.merged.vertices.size());
  Region region{.vertices = cache.uncut.merged.vertices, .vertex = {}};
  ChangedBoxes boxes;
  for (const MeshedCell& cell : cache.near) {
    std::vector<int>& vertex = region.vertex.emplace_back();
    for (std::size_t p = 0; p < cell.keys.size(); p++) {
      const SurfacePoint& point = cell.points.all[p];
      if (const int n = separate.find(cell.keys[p]); n >= 0) {
        if (!first[std::size_t(n)]) first[std::size_t(n)] = &point;
        vertex.push_back(uncut + n);
        continue;
      }
      const int v = cache.uncut.boxes.find(merge_key(input.model, point));
      TURGOR_CHECK(v >= 0, "points away from cuts belong to the uncut surface");
      boxes.add(input, v, cell.keys[p], point);
      vertex.push_back(v);
    }
  }

  // new positions
  for (std::size_t n = 0; n < boxes.sum.size(); n++)
    if (boxes.touches[n])
      region.vertices[std::size_t(boxes.vertex[n])] =
          merged_vertex(input, boxes.sum[n] / double(boxes.count[n]));
  for (const SurfacePoint* point : first) region.vertices.push_back(separate_vertex(input, *point));
  return region;
}

/// Triangles of one group: those of the uncut body, with the cells near blades replaced.
void join_triangles(const SurfaceCache& cache, const Region& region, std::size_t group,
                    std::vector<CellTriangle>& joined) {
  const std::vector<CellTriangle>& uncut = cache.uncut.merged.triangles[group];
  auto next = uncut.begin();
  for (std::size_t c = 0; c < cache.near.size(); c++) {
    const MeshedCell& cell = cache.near[c];
    const auto begin =
        std::partition_point(next, uncut.end(), [&](const CellTriangle& t) { return t.cell < cell.cell; });
    joined.insert(joined.end(), next, begin);
    next =
        std::partition_point(begin, uncut.end(), [&](const CellTriangle& t) { return t.cell == cell.cell; });
    for (const auto& [t, index] : cell.points.triangles[group])
      joined.push_back({{region.vertex[c][std::size_t(t.x)], region.vertex[c][std::size_t(t.y)],
                         region.vertex[c][std::size_t(t.z)]},
                        index});
  }
  joined.insert(joined.end(), next, uncut.end());
}

}  // namespace

BodySurface update_surface(const Exec& exec, const MeshInput& input, SurfaceCache& cache) {
  // uncut body
  const std::uint64_t removed = hash_removed_tissue(input.model, input.cuts);
  if (!cache.is_made || cache.removed != removed)
    cache = {.is_made = true, .removed = removed, .uncut = make_uncut(exec, input), .near = {}, .terms = {}};
  TURGOR_CHECK(std::is_sorted(cache.near.begin(), cache.near.end(),
                              [](const MeshedCell& a, const MeshedCell& b) { return a.cell < b.cell; }),
               "meshed cells ascend");

  // cells near blades
  update_cells(exec, input, cache.near);
  Region region = merge_region(input, cache);

  // whole surface
  MergedSurface merged;
  merged.vertices = std::move(region.vertices);
  parallel_for(exec, std::size_t(kSurfaceGroups),
               [&](std::size_t group) { join_triangles(cache, region, group, merged.triangles[group]); });
  for (std::size_t c = 0; c < cache.near.size(); c++)
    for (Lip lip : cache.near[c].points.lips) {
      lip.left = region.vertex[c][std::size_t(lip.left)],
      lip.right = region.vertex[c][std::size_t(lip.right)];
      merged.lips.push_back(lip);
    }
  return separate_groups(merged);
}

}  // namespace turgor::lattice::detail
