#include "turgor/sim/bodies/lattice/wall_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor {

namespace {

constexpr int kMostSegments = 8;                    // most segments of an edge
constexpr std::size_t kMostWallTriangles = 200000;  // of all walls

/// Value of the nearest voxel; empty outside of the volume.
template <class T>
std::optional<T> nearest_voxel(const Volume<T>& volume, Vec3d position) {
  if (volume.samples.empty()) return std::nullopt;
  const Vec3d at = index_at(volume.grid, position);
  const Int3 voxel{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
  if (!contains(volume.grid, voxel)) return std::nullopt;
  return volume.at(voxel.x, voxel.y, voxel.z);
}

/// Layer at a position and depth [m]: regions come first, and layers by depth leave out bone.
std::uint8_t look_at(const LatticeBody& body, Vec3d position, double depth) {
  const lattice::TissueParams& tissue = body.model.params.tissue;
  const std::vector<lattice::TissueLayer>& layers = tissue.layers;
  const int label = nearest_voxel(body.layers.labels, position).value_or(0);
  const double hu = nearest_voxel(body.ct, position).value_or(kAirHu);
  for (std::size_t n = 0; n < layers.size(); n++) {
    if (layers[n].label > 0 && layers[n].label == label) return std::uint8_t(n);
    if (layers[n].hu && hu >= (*layers[n].hu)[0] && hu <= (*layers[n].hu)[1]) return std::uint8_t(n);
  }
  if (hu >= tissue.bone_min) return WallLayers::kNoLayer;
  double bottom = 0;
  std::uint8_t last = WallLayers::kNoLayer;
  for (std::size_t n = 0; n < layers.size(); n++) {
    if (is_region(layers[n])) continue;
    last = std::uint8_t(n), bottom += layers[n].thickness;
    if (depth < bottom) return last;
  }
  return last;  // the rest of the body
}

/// Segments of each edge: a third of the thinnest layer, within limits.
int segments_of_edges(const LatticeBody& body, const RestWalls& surface) {
  double edge = 0, thinnest = 0;
  for (const Int3 t : surface.walls)
    for (int corner = 0; corner < 3; corner++)
      edge = std::max(
          edge, norm(surface.rest[std::size_t(t[corner])] - surface.rest[std::size_t(t[(corner + 1) % 3])]));
  for (const lattice::TissueLayer& layer : body.model.params.tissue.layers)
    if (layer.thickness > 0) thinnest = thinnest > 0 ? std::min(thinnest, layer.thickness) : layer.thickness;
  constexpr int kOfRegions = 4;
  const int wanted = thinnest > 0 ? int(std::ceil(std::min(100.0, 3 * edge / thinnest))) : kOfRegions;
  const int affordable = int(std::sqrt(double(kMostWallTriangles / surface.walls.size())));
  return std::max(1, std::min({wanted, kMostSegments, affordable}));
}

/// Divides each edge of the triangles into segments. Triangles share the vertices on their common edges.
void subdivide_walls(std::span<const Int3> triangles, int segments, WallLayers& fine) {
  std::map<std::array<int, 3>, int> on_edges;  // by both ends, and the share of the first one
  for (const Int3 t : triangles) {
    // vertex in a row between the first corner and the opposite edge
    const auto vertex_at = [&](int row, int i) {
      const Int3 share{segments - row, row - i, i};
      const auto add = [&] {
        fine.corner.push_back(t), fine.weight.push_back(Vec3(share) / Real(segments));
        return int(fine.corner.size()) - 1;
      };
      if (share.x > 0 && share.y > 0 && share.z > 0) return add();
      int ends[2]{-1, -1}, from_first = 0;
      for (int corner = 0; corner < 3; corner++)
        if (share[corner] > 0) (ends[0] < 0 ? ends[0] : ends[1]) = t[corner];
      if (ends[1] < 0) ends[1] = ends[0];
      const int first = std::min(ends[0], ends[1]);
      for (int corner = 0; corner < 3; corner++)
        if (t[corner] == first) from_first = share[corner];
      const auto [at, is_new] = on_edges.try_emplace({first, std::max(ends[0], ends[1]), from_first});
      if (is_new) at->second = add();
      return at->second;
    };
    std::vector<std::vector<int>> rows(std::size_t(segments) + 1);
    for (int row = 0; row <= segments; row++)
      for (int i = 0; i <= row; i++) rows[std::size_t(row)].push_back(vertex_at(row, i));
    for (std::size_t row = 0; row < std::size_t(segments); row++)
      for (std::size_t i = 0; i <= row; i++) {
        const std::vector<int>&above = rows[row], &below = rows[row + 1];
        fine.triangles.push_back({above[i], below[i], below[i + 1]});
        if (i < row) fine.triangles.push_back({above[i], below[i + 1], above[i + 1]});
      }
  }
}

}  // namespace

bool has_layer_colors(const LatticeBody& body) {
  return std::any_of(body.layer_colors.begin(), body.layer_colors.end(),
                     [](const std::optional<Rgb>& color) { return color.has_value(); });
}

WallLayers layers_on_walls(const Exec& exec, const LatticeBody& body, const RestWalls& surface) {
  WallLayers result;
  if (surface.walls.empty() || surface.skin.empty()) return result;
  const std::vector<lattice::TissueLayer>& layers = body.model.params.tissue.layers;
  TURGOR_CHECK(layers.size() == body.layer_colors.size(), "every layer has a color or none");
  for (std::size_t n = 0; n < layers.size(); n++)
    result.looks.push_back({layers[n].name, body.layer_colors[n]});
  subdivide_walls(surface.walls, segments_of_edges(body, surface), result);

  // depth of the walls' vertices below the skin
  const TriangleTree skin = build_triangle_tree({surface.rest.begin(), surface.rest.end()},
                                                {surface.skin.begin(), surface.skin.end()});
  std::vector<int> used;
  for (const Int3 t : surface.walls) used.insert(used.end(), {t.x, t.y, t.z});
  sort_unique(used);
  std::vector<double> depth(surface.rest.size());
  parallel_for(exec, used.size(), [&](std::size_t n) {
    const auto v = std::size_t(used[n]);
    depth[v] = nearest_point(skin, surface.rest[v]).distance;
  });

  // layer of each vertex, whose depth lies between those of the corners
  result.layer.resize(result.corner.size());
  parallel_for(exec, result.corner.size(), [&](std::size_t v) {
    Vec3d position;
    double below = 0;
    for (int corner = 0; corner < 3; corner++) {
      const auto at = std::size_t(result.corner[v][corner]);
      const double weight = double(result.weight[v][corner]);
      position += surface.rest[at] * weight, below += depth[at] * weight;
    }
    result.layer[v] = look_at(body, position, below);
  });
  return result;
}

}  // namespace turgor
