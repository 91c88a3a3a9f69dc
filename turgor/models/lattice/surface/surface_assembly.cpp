#include "turgor/models/lattice/surface/surface_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace turgor::lattice::detail {

namespace {

constexpr double kMergedPerStep = 1.5;  // merge boxes per cell

/// Merged points and their means.
struct Merged {
  std::vector<int> into;  // by point: merged point
  std::vector<Vec3d> sum;
  std::vector<int> count;
  std::vector<int> first;  // one point of each
};

Merged merge_points(const Model& model, const std::vector<SurfacePoint>& points) {
  Merged merged;
  KeyIndex index;
  std::vector<int> of_key;
  for (std::size_t n = 0; n < points.size(); n++) {
    const SurfacePoint& p = points[n];
    int into = -1;
    // points away from cuts share a merged point per box, border and kind
    if (!p.is_near_cut) {
      const int key = index.find_or_add(merge_key(model, p));
      if (std::size_t(key) == of_key.size()) of_key.push_back(-1);
      into = of_key[std::size_t(key)];
      if (into < 0) of_key[std::size_t(key)] = int(merged.sum.size());
    }
    // all others get one of their own
    if (into < 0) {
      into = int(merged.sum.size());
      merged.sum.push_back({}), merged.count.push_back(0), merged.first.push_back(int(n));
    }
    merged.into.push_back(into);
    merged.sum[std::size_t(into)] += p.position;
    merged.count[std::size_t(into)]++;
  }
  return merged;
}

/// Embedding of a position in the whole cell that contains it.
EmbeddingCell containing_cell(const Model& model, Vec3d position) {
  const Int3 last = model.anatomy.lattice.size - Int3{2, 2, 2};
  const Int3 cell{int(std::floor(position.x)), int(std::floor(position.y)), int(std::floor(position.z))};
  return {node_slot(model.anatomy.lattice, min(max(cell, Int3{0, 0, 0}), last)), -1};
}

Vec3 cell_coordinates(const Model& model, const EmbeddingCell& embedding, Vec3 rest) {
  const Int3 cell = slot_node(model.anatomy.lattice, embedding.cell);
  const Vec3 h = model.anatomy.lattice.spacing;
  return Vec3{rest.x / h.x, rest.y / h.y, rest.z / h.z} - Vec3(cell);
}

/// Node with the largest weight in the displacement of a corner; follows virtual nodes to their terms.
int dominant_node(const Fragments& fragments, int corner) {
  const int slots = slot_count(fragments.fine.cells);
  while (corner >= slots) {
    const VirtualNode& virtual_node = fragments.virtual_nodes[std::size_t(corner - slots)];
    const auto first = fragments.fit_terms.begin() + virtual_node.first_term,
               end = first + virtual_node.term_count;
    if (first == end) return virtual_node.slot;
    corner = std::max_element(first, end, [](const FitTerm& a, const FitTerm& b) {
               return a.weight < b.weight;
             })->corner;
  }
  return corner;
}

/// Tissue node with the largest weight in a vertex. If the corners are virtual nodes only, the node with the
/// largest product of weights.
int nearest_node(const Model& model, const Cuts& cuts, const Fragments& fragments,
                 const EmbeddingCell& embedding, Vec3 rest) {
  const auto corners = corners_of(model, fragments, embedding.cell, embedding.fragment);
  const auto weight = trilinear(cell_coordinates(model, embedding, rest));
  const int slots = slot_count(model.anatomy.lattice);
  int best = -1, source = embedding.cell;
  Real most = -1, most_source = -1;
  // largest weight among tissue nodes, and among the terms of virtual nodes
  for (std::size_t c = 0; c < 8; c++) {
    if (corners[c] < slots) {
      if (weight[c] > most && is_solid(model, cuts, corners[c])) most = weight[c], best = corners[c];
      continue;
    }
    const VirtualNode& virtual_node = fragments.virtual_nodes[std::size_t(corners[c] - slots)];
    for (int s = virtual_node.first_term; s < virtual_node.first_term + virtual_node.term_count; s++)
      if (const FitTerm& from = fragments.fit_terms[std::size_t(s)]; from.weight * weight[c] > most_source)
        most_source = from.weight * weight[c], source = dominant_node(fragments, from.corner);
  }
  return best >= 0 ? best : source;
}

/// Fragment of another cell that continues a fragment: the one of their common fine node nearest to a
/// position [cells]; -1 if the cells share no node of it.
int continued_fragment(const Fragments& fragments, const EmbeddingCell& from, Int3 cell, Vec3d position) {
  const FineLattice& f = fragments.fine;
  const CutCell *own = find_cell(fragments, from.cell),
                *other = find_cell(fragments, node_slot(f.cells, cell));
  if (own == nullptr || other == nullptr) return -1;
  const Int3 own_first = first_of_cell(f, slot_node(f.cells, from.cell)), first = first_of_cell(f, cell);
  int found = -1;
  double least = std::numeric_limits<double>::max();
  for_sub_nodes(f, [&](Int3 p) {
    const Int3 in_own = first + p - own_first;
    if (!in_cell(f, in_own)) return;
    const int label = fragments.label[other->first_sub_index + std::size_t(sub_index(f, p))];
    if (label < 0 ||
        fragments.label[own->first_sub_index + std::size_t(sub_index(f, in_own))] != from.fragment)
      return;
    const Vec3d away = lattice_index(f, first + p) - position;
    if (dot(away, away) < least) least = dot(away, away), found = label;
  });
  return found;
}

/// Embedding of a point near a cut. One that was moved onto a blade may lie beyond the cell of its side's
/// fine node. It belongs to the fragment that continues its own there; extrapolation would draw a tooth.
EmbeddingCell separate_embedding(const MeshInput& input, const SurfacePoint& point) {
  constexpr double kBeyond = 0.01;  // distance outside of a cell at which another one is sought [cells]
  const EmbeddingCell own = point.embedding;
  const Vec3d at = point.position - Vec3d(slot_node(input.model.anatomy.lattice, own.cell));
  const bool is_inside =
      std::min({at.x, at.y, at.z}) > -kBeyond && std::max({at.x, at.y, at.z}) < 1 + kBeyond;
  if (own.fragment < 0 || is_inside) return own;
  const EmbeddingCell containing = containing_cell(input.model, point.position);
  const int fragment = continued_fragment(
      input.fragments, own, slot_node(input.model.anatomy.lattice, containing.cell), point.position);
  return fragment < 0 ? own : EmbeddingCell{containing.cell, fragment};
}

}  // namespace

Points concatenate_slabs(const std::vector<SlabPoints>& slabs) {
  Points all;
  std::vector<int> below, number;  // numbers of a slab's points in the result
  for (std::size_t s = 0; s < slabs.size(); s++) {
    const SlabPoints& slab = slabs[s];
    // points shared with the slab below keep their numbers
    number.resize(slab.keys.size());
    for (std::size_t p = 0; p < number.size(); p++) {
      const int index_below = s > 0 ? slabs[s - 1].index.find(slab.keys[p]) : -1;
      number[p] = index_below >= 0 ? below[std::size_t(index_below)] : int(all.all.size());
      if (index_below < 0)
        all.all.push_back(slab.points.all[p]);
      else
        all.all[std::size_t(number[p])].is_near_cut |= slab.points.all[p].is_near_cut;
    }
    // renumber triangles and lips
    const auto in_all = [&number](int p) { return number[std::size_t(p)]; };
    for (std::size_t group = 0; group < all.triangles.size(); group++)
      for (const auto& [t, cell] : slab.points.triangles[group])
        all.triangles[group].push_back({{in_all(t.x), in_all(t.y), in_all(t.z)}, cell});
    for (Lip lip : slab.points.lips) {
      lip.left = in_all(lip.left), lip.right = in_all(lip.right);
      all.lips.push_back(lip);
    }
    below.swap(number);
  }
  return all;
}

Int3 merge_box(const SurfacePoint& point) {
  const Vec3d scaled = point.position * kMergedPerStep;
  return {int(std::floor(scaled.x)), int(std::floor(scaled.y)), int(std::floor(scaled.z))};
}

std::uint64_t merge_key(const Model& model, const SurfacePoint& point) {
  const Int3 size = model.anatomy.lattice.size * 2, box = merge_box(point);
  const std::uint64_t at =
      (std::uint64_t(box.z) * std::uint64_t(size.y) + std::uint64_t(box.y)) * std::uint64_t(size.x) +
      std::uint64_t(box.x);
  return (at * 64 + point.border) * 2 + point.is_skin;
}

MergedVertex separate_vertex(const MeshInput& input, const SurfacePoint& point) {
  const Vec3 rest(hadamard(point.position, Vec3d(input.model.anatomy.lattice.spacing)));
  const EmbeddingCell embedding = separate_embedding(input, point);
  return {rest, embedding, nearest_node(input.model, input.cuts, input.fragments, embedding, rest)};
}

MergedVertex merged_vertex(const MeshInput& input, Vec3d position) {
  const Vec3 rest(hadamard(position, Vec3d(input.model.anatomy.lattice.spacing)));
  const EmbeddingCell embedding = containing_cell(input.model, position);
  return {rest, embedding, nearest_node(input.model, input.cuts, input.fragments, embedding, rest)};
}

BodySurface separate_groups(const MergedSurface& merged) {
  BodySurface surface;
  std::vector<int> vertex(merged.vertices.size());
  // creates the vertex of a merged point
  const auto vertex_of = [&](int point) {
    int& v = vertex[std::size_t(point)];
    if (v >= 0) return v;
    v = int(surface.rest.size());
    const MergedVertex& made = merged.vertices[std::size_t(point)];
    surface.rest.push_back(made.rest), surface.embedding.push_back(made.embedding);
    surface.slot.push_back(made.slot);
    return v;
  };
  for (int group = 0; group < kSurfaceGroups; group++) {
    // triangles of each group, without degenerate ones
    std::fill(vertex.begin(), vertex.end(), -1);
    for (const auto& [t, cell] : merged.triangles[std::size_t(group)])
      if (t.x != t.y && t.y != t.z && t.z != t.x)
        surface.triangles.push_back({vertex_of(t.x), vertex_of(t.y), vertex_of(t.z)});
    const int count = int(surface.triangles.size());
    if (group != kSkin && group != kWall) surface.cap_triangles += count - surface.skin_triangles;
    if (group != kWall) surface.skin_triangles = count;
    surface.twin.resize(surface.rest.size(), -1);
    if (group != kSkin) continue;
    // lips of the skin
    for (Lip lip : merged.lips) {
      lip.left = vertex[std::size_t(lip.left)], lip.right = vertex[std::size_t(lip.right)];
      if (lip.left < 0 || lip.right < 0) continue;
      if (surface.twin[std::size_t(lip.left)] != lip.right) surface.lips.push_back(lip);
      surface.twin[std::size_t(lip.left)] = lip.right, surface.twin[std::size_t(lip.right)] = lip.left;
    }
  }
  return surface;
}

BodySurface assemble_surface(const MeshInput& input, const Points& points) {
  const Merged merged = merge_points(input.model, points.all);
  const auto into = [&merged](int point) { return merged.into[std::size_t(point)]; };
  MergedSurface surface;
  // vertices
  for (std::size_t m = 0; m < merged.sum.size(); m++) {
    const SurfacePoint& first = points.all[std::size_t(merged.first[m])];
    surface.vertices.push_back(first.is_near_cut
                                   ? separate_vertex(input, first)
                                   : merged_vertex(input, merged.sum[m] / double(merged.count[m])));
  }
  // triangles and lips
  for (std::size_t group = 0; group < kSurfaceGroups; group++)
    for (const auto& [t, cell] : points.triangles[group])
      surface.triangles[group].push_back({{into(t.x), into(t.y), into(t.z)}, cell});
  for (Lip lip : points.lips) {
    lip.left = into(lip.left), lip.right = into(lip.right);
    surface.lips.push_back(lip);
  }
  return separate_groups(surface);
}

}  // namespace turgor::lattice::detail

namespace turgor::lattice {

Vec3 vertex_displacement(const Model& model, const State& state, const BodySurface& surface, int vertex) {
  const auto v = std::size_t(vertex);
  const auto corners =
      corners_of(model, *surface.fragments, surface.embedding[v].cell, surface.embedding[v].fragment);
  const auto weight = trilinear(detail::cell_coordinates(model, surface.embedding[v], surface.rest[v]));
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (weight[c] != 0) sum += corner_displacement(model, state, *surface.fragments, corners[c]) * weight[c];
  return sum;
}

void add_support_nodes(const Model& model, const Cuts& cuts,
                       std::span<const VirtualNodeDisplacement> virtual_u, const BodySurface& surface,
                       int vertex, std::vector<int>& nodes) {
  const EmbeddingCell& embedding = surface.embedding[std::size_t(vertex)];
  for (const int corner : corners_of(model, *surface.fragments, embedding.cell, embedding.fragment))
    add_support_nodes(model, cuts, virtual_u, *surface.fragments, corner, nodes);
}

}  // namespace turgor::lattice
