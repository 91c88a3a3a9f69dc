#include "turgor/models/lattice/surface/surface_assembly.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::lattice::detail {

namespace {

constexpr double kMergedPerStep = 1.5;  // boxes whose points become one

/// Which points become one, and where it is.
struct Merged {
  std::vector<int> into;  // by point
  std::vector<Vec3d> sum;
  std::vector<int> count;
  std::vector<int> first;  // one of its points
};

Merged merge_points(const Model& model, const std::vector<SurfacePoint>& points) {
  Merged merged;
  KeyIndex index;
  std::vector<int> of_key;
  const Int3 size = model.lattice.size * 2;
  for (std::size_t n = 0; n < points.size(); n++) {
    const SurfacePoint& p = points[n];
    int into = -1;
    if (!p.kept) {
      const Vec3d part = p.place * kMergedPerStep;
      const Int3 box{int(std::floor(part.x)), int(std::floor(part.y)), int(std::floor(part.z))};
      const std::uint64_t at =
          (std::uint64_t(box.z) * std::uint64_t(size.y) + std::uint64_t(box.y)) * std::uint64_t(size.x) +
          std::uint64_t(box.x);
      const int key = index.find_or_add((at * 64 + p.border) * 2 + p.is_skin);
      if (std::size_t(key) == of_key.size()) of_key.push_back(-1);
      into = of_key[std::size_t(key)];
      if (into < 0) of_key[std::size_t(key)] = int(merged.sum.size());
    }
    if (into < 0) {
      into = int(merged.sum.size());
      merged.sum.push_back({}), merged.count.push_back(0), merged.first.push_back(int(n));
    }
    merged.into.push_back(into);
    merged.sum[std::size_t(into)] += p.place;
    merged.count[std::size_t(into)]++;
  }
  return merged;
}

/// A cell that holds a place and has tissue.
Carrier whole_cell(const Model& model, Vec3d place) {
  const Int3 last = model.lattice.size - Int3{2, 2, 2};
  const Int3 cell{int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z))};
  return {node_slot(model.lattice, min(max(cell, Int3{0, 0, 0}), last)), -1};
}

Vec3 in_cell_at(const Model& model, const Carrier& carrier, Vec3 rest) {
  const Int3 cell = slot_node(model.lattice, carrier.cell);
  const Vec3 h = model.lattice.step;
  return Vec3{rest.x / h.x, rest.y / h.y, rest.z / h.z} - Vec3(cell);
}

/// The node that a copy takes most of its displacement from when it bears nothing.
int source_node(const Fragments& pieces, int corner) {
  const int slots = slot_count(pieces.fine.cells);
  while (corner >= slots) {
    const VirtualNode& copy = pieces.virtual_nodes[std::size_t(corner - slots)];
    const auto first = pieces.sources.begin() + copy.first, end = first + copy.source_count;
    if (first == end) return copy.slot;
    corner = std::max_element(first, end, [](const FitTerm& a, const FitTerm& b) {
               return a.weight < b.weight;
             })->corner;
  }
  return corner;
}

/// The node of tissue with the largest share in a vertex; of a copy, its nearest source.
int nearest_node(const Model& model, const State& state, const Fragments& pieces, const Carrier& carrier,
                 Vec3 rest) {
  const auto corners = corners_of(model, pieces, carrier.cell, carrier.piece);
  const auto weight = trilinear(in_cell_at(model, carrier, rest));
  const int slots = slot_count(model.lattice);
  int best = -1, source = carrier.cell;
  Real most = -1, most_source = -1;
  for (std::size_t c = 0; c < 8; c++) {
    if (corners[c] < slots) {
      if (weight[c] > most && is_solid(model, state, corners[c])) most = weight[c], best = corners[c];
      continue;
    }
    const VirtualNode& copy = pieces.virtual_nodes[std::size_t(corners[c] - slots)];
    for (int s = copy.first; s < copy.first + copy.source_count; s++)
      if (const FitTerm& from = pieces.sources[std::size_t(s)]; from.weight * weight[c] > most_source)
        most_source = from.weight * weight[c], source = source_node(pieces, from.corner);
  }
  return best >= 0 ? best : source;
}

}  // namespace

Points joined(const std::vector<KnownPoints>& slabs) {
  Points all;
  std::vector<int> below, number;  // those of a slab's points in all
  for (std::size_t s = 0; s < slabs.size(); s++) {
    const KnownPoints& slab = slabs[s];
    number.resize(slab.keys.size());
    for (std::size_t p = 0; p < number.size(); p++) {
      const int there = s > 0 ? slabs[s - 1].index.find(slab.keys[p]) : -1;
      number[p] = there >= 0 ? below[std::size_t(there)] : int(all.all.size());
      if (there < 0)
        all.all.push_back(slab.points.all[p]);
      else
        all.all[std::size_t(number[p])].kept |= slab.points.all[p].kept;
    }
    const auto in_all = [&number](int p) { return number[std::size_t(p)]; };
    for (std::size_t part = 0; part < all.triangles.size(); part++)
      for (const Int3 t : slab.points.triangles[part])
        all.triangles[part].push_back({in_all(t.x), in_all(t.y), in_all(t.z)});
    for (Lip lip : slab.points.lips) {
      lip.left = in_all(lip.left), lip.right = in_all(lip.right);
      all.lips.push_back(lip);
    }
    below.swap(number);
  }
  return all;
}

void take_points(const Model& model, const State& state, const Points& points, BodySurface& surface) {
  const Merged merged = merge_points(model, points.all);
  std::vector<int> vertex(merged.sum.size());
  const auto vertex_of = [&](int point) {
    const auto into = std::size_t(merged.into[std::size_t(point)]);
    int& v = vertex[into];
    if (v >= 0) return v;
    v = int(surface.rest.size());
    const SurfacePoint& first = points.all[std::size_t(merged.first[into])];
    const Vec3d place = merged.sum[into] / double(merged.count[into]);
    surface.rest.push_back(Vec3(hadamard(place, Vec3d(model.lattice.step))));
    surface.carrier.push_back(first.kept ? first.carrier : whole_cell(model, place));
    return v;
  };
  for (int part = 0; part < kParts; part++) {
    std::fill(vertex.begin(), vertex.end(), -1);
    for (const Int3 t : points.triangles[std::size_t(part)]) {
      const int a = merged.into[std::size_t(t.x)], b = merged.into[std::size_t(t.y)],
                c = merged.into[std::size_t(t.z)];
      if (a == b || b == c || c == a) continue;
      surface.triangles.push_back({vertex_of(t.x), vertex_of(t.y), vertex_of(t.z)});
    }
    if (part != kWall) surface.skin_triangles = int(surface.triangles.size());
    surface.twin.resize(surface.rest.size(), -1);
    if (part != kSkin) continue;
    for (Lip lip : points.lips) {
      lip.left = vertex[std::size_t(merged.into[std::size_t(lip.left)])];
      lip.right = vertex[std::size_t(merged.into[std::size_t(lip.right)])];
      if (lip.left < 0 || lip.right < 0) continue;
      if (surface.twin[std::size_t(lip.left)] != lip.right) surface.lips.push_back(lip);
      surface.twin[std::size_t(lip.left)] = lip.right, surface.twin[std::size_t(lip.right)] = lip.left;
    }
  }
  for (std::size_t v = 0; v < surface.rest.size(); v++)
    surface.slot.push_back(nearest_node(model, state, surface.pieces, surface.carrier[v], surface.rest[v]));
}

}  // namespace turgor::lattice::detail

namespace turgor::lattice {

Vec3 vertex_displacement(const Model& model, const State& state, const BodySurface& surface, int vertex) {
  const auto v = std::size_t(vertex);
  const auto corners = corners_of(model, surface.pieces, surface.carrier[v].cell, surface.carrier[v].piece);
  const auto weight = trilinear(detail::in_cell_at(model, surface.carrier[v], surface.rest[v]));
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (weight[c] != 0) sum += corner_displacement(model, state, surface.pieces, corners[c]) * weight[c];
  return sum;
}

void add_nodes_behind(const Model& model, const State& state, const BodySurface& surface, int vertex,
                      std::vector<int>& nodes) {
  const Carrier& carrier = surface.carrier[std::size_t(vertex)];
  for (const int corner : corners_of(model, surface.pieces, carrier.cell, carrier.piece))
    add_nodes_behind(model, state, surface.pieces, corner, nodes);
}

}  // namespace turgor::lattice
