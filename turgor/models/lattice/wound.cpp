// Measures of a wound: how far the two lips of a cut have gone apart.
#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/incision.hpp"

namespace turgor::lattice {

namespace {

/// Two skin nodes that were neighbours across the cut.
struct LipPair {
  double along;  // where on the cut, in the CT [m]
  double gape;   // opening across the cut since the CT [m]
  double moved;  // the larger displacement of the two [m]
};

bool is_skin(const Skin& skin, int slot) {
  return std::binary_search(skin.nodes.begin(), skin.nodes.end(), slot);
}

LipPair lip_pair(const Model& model, const State& state, const BladePath& path, const CutEdge& edge,
                 Vec3d line) {
  const Int3 a = slot_node(model.lattice, edge.slot), b = a + kFamilies[edge.family];
  const Vec3d rest_a(rest_position(model.lattice, a)), rest_b(rest_position(model.lattice, b));
  const Vec3d ua(state.u[std::size_t(edge.slot)]), ub(state.u[std::size_t(node_slot(model.lattice, b))]);
  const double sign = dot(rest_b - rest_a, path.across) >= 0 ? 1 : -1;
  return {.along = dot(rest_a + (rest_b - rest_a) * double(edge.fraction) - path.skin.front(), line),
          .gape = sign * dot(ub - ua, path.across),
          .moved = std::max(norm(ua), norm(ub))};
}

/// Lips of a cut through edges: the skin edges that were cut.
std::vector<LipPair> cut_lips(const Model& model, const State& state, const BladePath& path, int incision,
                              Vec3d line) {
  std::vector<LipPair> pairs;
  for (const CutEdge& edge : state.cut_edges) {
    if (edge.incision != incision) continue;
    const int other = node_slot(model.lattice, slot_node(model.lattice, edge.slot) + kFamilies[edge.family]);
    if (state.removed[std::size_t(edge.slot)] || state.removed[std::size_t(other)]) continue;
    if (is_skin(model.skin, edge.slot) && is_skin(model.skin, other))
      pairs.push_back(lip_pair(model, state, path, edge, line));
  }
  return pairs;
}

/// Lips of a removed region: skin nodes beside it, each paired with the nearest one along the cut on the
/// other side.
std::vector<LipPair> region_lips(const Model& model, const State& state, const BladePath& path, int incision,
                                 Vec3d line) {
  struct Lip {
    double along, across;
    Vec3d u;
  };
  std::vector<Lip> sides[2];
  std::vector<int> seen;
  for (const CutEdge& edge : state.cut_edges) {
    if (edge.incision != incision) continue;
    const int other = node_slot(model.lattice, slot_node(model.lattice, edge.slot) + kFamilies[edge.family]);
    const int slot = state.removed[std::size_t(edge.slot)] ? other : edge.slot;
    if (state.removed[std::size_t(slot)] || !is_skin(model.skin, slot)) continue;
    seen.push_back(slot);
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const int slot : seen) {
    const Vec3d rest(rest_position(model.lattice, slot_node(model.lattice, slot)));
    const double across = dot(rest - path.skin.front(), path.across);
    sides[across >= 0].push_back(
        {dot(rest - path.skin.front(), line), across, Vec3d(state.u[std::size_t(slot)])});
  }
  std::vector<LipPair> pairs;
  for (const Lip& lip : sides[1]) {
    const auto nearest = std::min_element(sides[0].begin(), sides[0].end(), [&](const Lip& a, const Lip& b) {
      return std::abs(a.along - lip.along) < std::abs(b.along - lip.along);
    });
    if (nearest == sides[0].end()) continue;
    pairs.push_back({.along = lip.along,
                     .gape = dot(lip.u - nearest->u, path.across),
                     .moved = std::max(norm(lip.u), norm(nearest->u))});
  }
  return pairs;
}

}  // namespace

Wound measure_wound(const Model& model, const State& state, const BladePath& path, int incision) {
  const Vec3d line = cross(path.into, path.across);
  std::vector<LipPair> pairs = cut_lips(model, state, path, incision, line);
  if (pairs.empty()) pairs = region_lips(model, state, path, incision, line);
  Wound wound;
  if (pairs.empty()) return wound;
  std::sort(pairs.begin(), pairs.end(), [](const LipPair& a, const LipPair& b) { return a.along < b.along; });

  // Mean over bins of about a lattice step along the cut.
  const double begin = pairs.front().along, end = pairs.back().along;
  const double span = end > begin ? end - begin : 1;  // a single pair has none
  const double step = std::max({model.lattice.step.x, model.lattice.step.y, model.lattice.step.z});
  const int bins = std::max(1, int((end - begin) / step));
  std::vector<GapePoint> sums(static_cast<std::size_t>(bins));
  std::vector<int> counts(static_cast<std::size_t>(bins), 0);
  for (const LipPair& pair : pairs) {
    const auto bin = std::size_t(std::clamp(int(bins * (pair.along - begin) / span), 0, bins - 1));
    sums[bin].along += pair.along;
    sums[bin].gape += pair.gape;
    counts[bin]++;
    wound.edge_displacement = std::max(wound.edge_displacement, pair.moved);
  }
  for (std::size_t b = 0; b < sums.size(); b++)
    if (counts[b] > 0) wound.profile.push_back({sums[b].along / counts[b], sums[b].gape / counts[b]});

  wound.length = end - begin;
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

}  // namespace turgor::lattice
