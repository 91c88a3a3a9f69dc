#include "turgor/models/lattice/cut_tet.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace turgor::lattice {

namespace {

constexpr int kNeighbours = 2 * kFamilyCount;

constexpr Int3 neighbour_offset(int n) {
  const Int3 offset = kFamilies[std::size_t(n % kFamilyCount)];
  return n < kFamilyCount ? offset : -offset;
}

constexpr bool is_negative(Int3 d) { return d.x < 0 || d.y < 0 || d.z < 0; }

std::uint64_t edge_key(int slot, int family) { return std::uint64_t(slot) * 8 + std::uint64_t(family); }

/// On which side each corner's share of a tetrahedron with two sides lies; what fits no plane is shared
/// evenly.
std::array<float, 4> corner_levels(const CutBody& body, const TetNodes& nodes, const TetSides& sides) {
  std::array<int, 4> signs{};
  for (std::size_t n = 0; n < 4; n++)
    if (sides.side[n] >= 0) signs[n] = sides.side[n] == 0 ? 1 : -1;
  const CutLevel level = fit_level(body, nodes, signs);
  std::array<float, 4> result{};
  bool separates = true;
  for (std::size_t n = 0; n < 4; n++) {
    result[n] = float(level.at(Vec3d(nodes[n])));
    separates &= result[n] * float(signs[n]) >= 0;
  }
  for (std::size_t n = 0; n < 4 && !separates; n++) result[n] = float(signs[n]);
  return result;
}

}  // namespace

CutBody make_cut_body(const Model& model, const State& state) {
  CutBody body{.model = model, .state = state, .solid = {}, .crossings = {}};
  body.solid.resize(model.tissue.size());
  for (std::size_t s = 0; s < body.solid.size(); s++)
    body.solid[s] = is_body(model.tissue[s]) && !(s < state.removed.size() && state.removed[s]);
  body.crossings.reserve(state.cut_edges.size());
  for (const CutEdge& edge : state.cut_edges)
    body.crossings.emplace_back(edge_key(edge.slot, edge.family),
                                std::clamp(edge.fraction, Real(0.01), Real(0.99)));
  std::stable_sort(body.crossings.begin(), body.crossings.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return body;
}

bool is_cut(const CutBody& body, Int3 a, Int3 b) {
  if (is_negative(b - a)) std::swap(a, b);
  const Lattice& l = body.model.lattice;
  const auto slot = std::size_t(node_slot(l, a));
  if (body.state.cut[slot] == 0 || !(body.state.cut[slot] >> family_of(b - a) & 1)) return false;
  return body.solid[slot] && is_solid(body, b);
}

Real crossing(const CutBody& body, Int3 a, Int3 b) {
  const bool swapped = is_negative(b - a);
  if (swapped) std::swap(a, b);
  const std::uint64_t key = edge_key(node_slot(body.model.lattice, a), family_of(b - a));
  const auto found = std::lower_bound(body.crossings.begin(), body.crossings.end(), key,
                                      [](const auto& entry, std::uint64_t k) { return entry.first < k; });
  const Real fraction = found != body.crossings.end() && found->first == key ? found->second : Real(0.5);
  return swapped ? 1 - fraction : fraction;
}

CutLevel fit_level(const CutBody& body, std::span<const Int3> nodes, std::span<const int> signs) {
  CutLevel level{.origin = Vec3d(nodes[0]), .gradient = {}, .offset = 0};
  const auto row_of = [&](Vec3d point) {
    const Vec3d d = point - level.origin;
    return Eigen::Vector4d(d.x, d.y, d.z, 1);
  };
  Eigen::Matrix4d normal = 1e-9 * Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t n = 0; n < nodes.size(); n++) {
    if (signs[n] == 0) continue;
    right += signs[n] * row_of(Vec3d(nodes[n]));
    for (int m = 0; m < kNeighbours; m++) {
      const Int3 other = nodes[n] + neighbour_offset(m);
      if (!is_cut(body, nodes[n], other)) continue;
      const bool own = std::find(nodes.begin(), nodes.end(), other) != nodes.end();
      const Vec3d point = Vec3d(nodes[n]) + Vec3d(other - nodes[n]) * double(crossing(body, nodes[n], other));
      normal += (own ? 1.0 : 1e-4) * row_of(point) * row_of(point).transpose();
    }
  }
  const Eigen::Vector4d solution = normal.ldlt().solve(right);
  const double scale = solution.head<3>().norm();
  if (!(scale > 0)) return level;
  level.gradient = {solution[0] / scale, solution[1] / scale, solution[2] / scale};
  level.offset = solution[3] / scale;
  return level;
}

std::optional<CutLevel> level_beside(const CutBody& body, Int3 node) {
  std::array<Int3, 1 + kNeighbours> nodes{node};
  std::array<int, 1 + kNeighbours> signs{-1};
  std::size_t count = 1;
  for (int n = 0; n < kNeighbours; n++)
    if (const Int3 other = node + neighbour_offset(n); is_cut(body, node, other))
      nodes[count] = other, signs[count++] = 1;
  if (count == 1) return {};
  const CutLevel level = fit_level(body, {nodes.data(), count}, {signs.data(), count});
  if (level.at(Vec3d(node)) >= 0) return {};
  return level;
}

TetSides split_tet(const CutBody& body, const TetNodes& nodes) {
  TetSides sides;
  sides.side.fill(-1);
  for (std::size_t n = 0; n < 4; n++) {
    const auto slot = std::size_t(node_slot(body.model.lattice, nodes[n]));
    sides.removed[n] = !body.solid[slot] && is_body(body.model.tissue[slot]);
    if (body.solid[slot]) sides.side[n] = int(n);
  }
  // Three rounds let the smallest number reach every node that is joined to it.
  for (int round = 0; round < 3; round++)
    for (std::size_t a = 0; a < 4; a++)
      for (std::size_t b = a + 1; b < 4; b++) {
        if (sides.side[a] < 0 || sides.side[b] < 0 || is_cut(body, nodes[a], nodes[b])) continue;
        sides.side[a] = sides.side[b] = std::min(sides.side[a], sides.side[b]);
      }
  std::array<int, 4> name{-1, -1, -1, -1};
  for (int& side : sides.side) {
    if (side < 0) continue;
    int& known = name[std::size_t(side)];
    if (known < 0) known = sides.count++;
    side = known;
  }
  if (sides.count == 2) sides.level = corner_levels(body, nodes, sides);
  return sides;
}

Vec3 ghost_displacement(const CutBody& body, Int3 node, Int3 seen_from) {
  const bool across_cut = is_solid(body, node);
  std::array<Int3, kNeighbours> found;
  int count = 0;
  found[std::size_t(count++)] = seen_from;
  std::array<bool, kNeighbours> taken{};
  for (int n = 0; n < kNeighbours; n++) taken[std::size_t(n)] = node + neighbour_offset(n) == seen_from;
  for (int next = 0; next < count; next++) {
    const Int3 a = found[std::size_t(next)];
    for (int n = 0; n < kNeighbours; n++) {
      const Int3 b = node + neighbour_offset(n), apart = b - a;
      if (taken[std::size_t(n)] || !is_solid(body, b)) continue;
      if (family_of(apart) < 0 && family_of(-apart) < 0) continue;
      if (is_cut(body, a, b) || (across_cut && !is_cut(body, node, b))) continue;
      taken[std::size_t(n)] = true;
      found[std::size_t(count++)] = b;
    }
  }
  // Summed in the neighbours' own order, so that the bits do not depend on where the search began.
  // Displacements go on along the line from the node behind each neighbour.
  const VecField& u = body.state.u;
  Vec3 sum;
  for (int n = 0; n < kNeighbours; n++) {
    if (!taken[std::size_t(n)]) continue;
    const Int3 beside = node + neighbour_offset(n), behind = beside + neighbour_offset(n);
    const Vec3 here = u[std::size_t(node_slot(body.model.lattice, beside))];
    const bool goes_on = is_solid(body, behind) && !is_cut(body, beside, behind);
    sum += goes_on ? here * Real(2) - u[std::size_t(node_slot(body.model.lattice, behind))] : here;
  }
  return sum / Real(count);
}

}  // namespace turgor::lattice
