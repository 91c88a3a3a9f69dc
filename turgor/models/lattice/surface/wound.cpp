// Wound measures: opening between the two lips of a cut.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/cutting/rim.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {

namespace {

/// Pair of points on the two lips that coincided at rest.
struct LipPair {
  double along;  // arc length along the cut [m]
  double gape;   // opening across the cut since the CT [m]
  double moved;  // larger displacement of the two [m]
};

Vec3d across_along(const BladePath& path, double along) {
  const PathPosition at = position_along(path, along);
  const std::size_t next = std::min(at.segment + 1, path.points.size() - 1);
  return normalized(across_at(path, at.segment) * (1 - at.fraction) + across_at(path, next) * at.fraction);
}

std::vector<LipPair> drawn_lips(const Model& model, const State& state, const BodySurface& surface,
                                const BladePath& path, int incision) {
  std::vector<LipPair> pairs;
  for (const Lip& lip : surface.lips) {
    if (lip.incision != incision) continue;
    const Vec3d left(vertex_displacement(model, state, surface, lip.left)),
        right(vertex_displacement(model, state, surface, lip.right));
    pairs.push_back({.along = double(lip.along),
                     .gape = dot(right - left, across_along(path, double(lip.along))),
                     .moved = std::max(norm(left), norm(right))});
  }
  return pairs;
}

/// Skin node at the border of a removed region, in coordinates of the region's path.
struct RegionLipNode {
  double along, across;
  int slot;
};
std::vector<RegionLipNode> region_lip_nodes(const Model& model, const Cuts& cuts, const BladePath& path) {
  TURGOR_CHECK(!path.points.empty(), "a path has points");
  const Vec3d line = normalized(path.points.back() - path.points.front()), across = across_at(path, 0);
  const double length = norm(path.points.back() - path.points.front()),
               step = double(std::max({model.anatomy.lattice.spacing.x, model.anatomy.lattice.spacing.y,
                                       model.anatomy.lattice.spacing.z}));
  std::vector<RegionLipNode> found;
  for (const int slot : model.anatomy.skin.nodes) {
    if (cuts.removed[std::size_t(slot)]) continue;
    const Int3 node = slot_node(model.anatomy.lattice, slot);
    // nodes with a removed neighbor
    bool is_at_region = false;
    for (const Int3 f : kFamilies)
      for (const Int3 offset : {f, -f})
        is_at_region |= contains(model.anatomy.lattice, node + offset) &&
                        is_removed_tissue(model, cuts, node_slot(model.anatomy.lattice, node + offset));
    if (!is_at_region) continue;
    // near the region
    const Vec3d away = Vec3d(rest_position(model.anatomy.lattice, node)) - path.points.front();
    const RegionLipNode lip{dot(away, line), dot(away, across), slot};
    if (lip.along > -2 * step && lip.along < length + 2 * step &&
        std::abs(lip.across) < path.width / 2 + 2 * step)
      found.push_back(lip);
  }
  return found;
}

/// Lips of a removed region: skin nodes at its border. Each node on one side is paired with the nearest one
/// along the cut on the other side.
std::vector<LipPair> region_lips(const Model& model, const State& state, const BladePath& path) {
  std::vector<RegionLipNode> sides[2];
  // nodes on each side of the cut
  for (const RegionLipNode& lip : region_lip_nodes(model, state.cuts, path))
    sides[lip.across >= 0].push_back(lip);
  std::vector<LipPair> pairs;
  const auto u = [&](const RegionLipNode& lip) { return Vec3d(state.motion.u[std::size_t(lip.slot)]); };
  // pairs of nearest nodes along the cut
  for (const RegionLipNode& lip : sides[1]) {
    const auto nearest = std::min_element(
        sides[0].begin(), sides[0].end(), [&](const RegionLipNode& a, const RegionLipNode& b) {
          return std::abs(a.along - lip.along) < std::abs(b.along - lip.along);
        });
    if (nearest == sides[0].end()) continue;
    pairs.push_back({.along = lip.along,
                     .gape = dot(u(lip) - u(*nearest), across_at(path, 0)),
                     .moved = std::max(norm(u(lip)), norm(u(*nearest)))});
  }
  return pairs;
}

/// Profile of means over bins of about one cell along the cut.
void add_profile(const Model& model, const std::vector<LipPair>& pairs, Wound& wound) {
  TURGOR_CHECK(!pairs.empty() && is_ascending(pairs, &LipPair::along), "pairs ascend along the cut");
  const double begin = pairs.front().along, end = pairs.back().along;
  const double span = end > begin ? end - begin : 1;  // nonzero for a single pair
  const double step = double(std::max(
      {model.anatomy.lattice.spacing.x, model.anatomy.lattice.spacing.y, model.anatomy.lattice.spacing.z}));
  const int bins = std::max(1, int((end - begin) / step));
  std::vector<GapePoint> sums(static_cast<std::size_t>(bins));
  std::vector<int> counts(static_cast<std::size_t>(bins), 0);
  // sums per bin
  for (const LipPair& pair : pairs) {
    const auto bin = std::size_t(std::clamp(int(bins * (pair.along - begin) / span), 0, bins - 1));
    sums[bin].along += pair.along;
    sums[bin].gape += pair.gape;
    counts[bin]++;
    wound.edge_displacement = std::max(wound.edge_displacement, pair.moved);
  }
  // means
  for (std::size_t b = 0; b < sums.size(); b++)
    if (counts[b] > 0) wound.profile.push_back({sums[b].along / counts[b], sums[b].gape / counts[b]});
  wound.length = end - begin;
}

Wound wound_of(const Model& model, std::vector<LipPair> pairs) {
  Wound wound;
  if (pairs.empty()) return wound;
  // profile along the cut
  std::sort(pairs.begin(), pairs.end(), [](const LipPair& a, const LipPair& b) { return a.along < b.along; });
  add_profile(model, pairs, wound);
  // largest gape, and area by the trapezoidal rule
  for (std::size_t n = 0; n < wound.profile.size(); n++) {
    const GapePoint& point = wound.profile[n];
    wound.gape_max = n == 0 ? point.gape : std::max(wound.gape_max, point.gape);
    if (n == 0) continue;
    const GapePoint& before = wound.profile[n - 1];
    wound.opening_area +=
        0.5 * (std::max(0.0, point.gape) + std::max(0.0, before.gape)) * (point.along - before.along);
  }
  if (wound.length > 0) wound.gape_mean = wound.opening_area / wound.length;
  return wound;
}

/// Wound that a piece has left: its gape is the distance of opposite points of the rim across the wound. Lips
/// that meet may be shifted along the wound or in height, and do not gape.
Wound excised_wound(const BladePath& path, const Opening& opening) {
  Wound wound;
  wound.length = opening.size.length, wound.edge_displacement = opening.displacement;
  const std::size_t last = path.points.size() - 1, middle = last / 4;
  const Vec3d across = normalized(path.points[last - middle] - path.points[middle]);
  double along = 0, area = 0;
  const std::vector<Vec3d> axis = axis_of(path).points;
  for (std::size_t n = 0; n < axis.size(); n++) {
    const double step = n > 0 ? norm(axis[n] - axis[n - 1]) : 0;
    const double gape = std::max(0.0, dot(opening.rim[last - n] - opening.rim[n], across));
    along += step;
    if (n > 0) area += 0.5 * (gape + wound.profile.back().gape) * step;
    wound.profile.push_back({along, gape});
    wound.gape_max = std::max(wound.gape_max, gape);
  }
  if (along > 0) wound.gape_mean = area / along;
  wound.opening_area = wound.gape_mean * wound.length;
  return wound;
}

}  // namespace

Wound measure_wound(const Model& model, const State& state, const BodySurface& surface, const BladePath& path,
                    int incision) {
  if (path.is_excision && !state.cuts.excised.empty() &&
      !state.cuts.active_blades.test(std::uint8_t(incision)))
    if (const auto opening = opening_of(model, state, path)) return excised_wound(path, *opening);
  return wound_of(model, path.width > 0 ? region_lips(model, state, path)
                                        : drawn_lips(model, state, surface, path, incision));
}

std::vector<int> wound_support_nodes(const Model& model, const Cuts& cuts,
                                     std::span<const VirtualNodeDisplacement> virtual_u,
                                     const BodySurface& surface, const BladePath& path, int incision) {
  std::vector<int> nodes;
  if (path.width > 0)
    for (const RegionLipNode& lip : region_lip_nodes(model, cuts, path)) nodes.push_back(lip.slot);
  else
    for (const Lip& lip : surface.lips)
      if (lip.incision == incision)
        for (const int v : {lip.left, lip.right})
          add_support_nodes(model, cuts, virtual_u, surface, v, nodes);
  sort_unique(nodes);
  return nodes;
}

Wound measure_wound(const Model& model, const State& state, const BladePath& path, int incision) {
  return measure_wound(model, state, build_surface(model, state.cuts, nullptr, Extent::kCuts), path,
                       incision);
}

}  // namespace turgor::lattice
