#include "turgor/geometry/curve_sides.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor {

namespace {

constexpr double kFarthest = 0.25;  // largest move of a midside node, in edge lengths

/// Midside node of an outer edge and its displacement.
struct OuterMiddle {
  int node = 0, from = 0, to = 0;  // midside node, ends of its edge
  Vec3d normal;                    // unit outward normal of the faces at the edge
  double shift = 0;                // along the normal [m]
};

/// Midside nodes of all outer edges, in ascending order.
std::vector<OuterMiddle> outer_middles(const SolidMesh& mesh) {
  std::vector<OuterMiddle> all(mesh.vertices.size());
  const auto faces = element_faces(mesh);
  const std::vector<int> neighbors = face_neighbors(mesh);
  for (std::size_t i = 0; i < neighbors.size(); i++) {
    if (neighbors[i] >= 0) continue;
    const auto nodes = element(mesh, i / faces.size());
    const auto& face = faces[i % faces.size()];
    const auto node = [&](int c) { return nodes[std::size_t(face[std::size_t(c)])]; };
    const auto x = [&](int c) { return mesh.vertices[std::size_t(node(c))]; };
    const Vec3d area = cross(x(1) - x(0), x(2) - x(0));
    for (int c = 0; c < 3; c++) {
      const int next = (c + 1) % 3;
      const int middle = nodes[std::size_t(node_between(face[std::size_t(c)], face[std::size_t(next)]))];
      OuterMiddle& m = all[std::size_t(middle)];
      m = {middle, std::min(node(c), node(next)), std::max(node(c), node(next)), m.normal + area, 0};
    }
  }
  all.erase(std::remove_if(all.begin(), all.end(), [](const OuterMiddle& m) { return m.from == m.to; }),
            all.end());
  for (OuterMiddle& m : all) m.normal = normalized(m.normal);
  return all;
}

/// Distance along the normal to the surface by secant steps. The first step assumes that the distance is
/// exact.
double shift_to_surface(const SolidMesh& mesh, const OuterMiddle& m,
                        const std::function<double(Vec3d)>& distance) {
  const Vec3d x = mesh.vertices[std::size_t(m.node)];
  const double length = norm(mesh.vertices[std::size_t(m.to)] - mesh.vertices[std::size_t(m.from)]);
  const double most = kFarthest * length;
  double before = 0, off_before = distance(x), now = std::clamp(-off_before, -most, most);
  for (int pass = 0; pass < 6; pass++) {
    const double off = distance(x + m.normal * now);
    if (std::abs(off) < 1e-4 * length || off == off_before) break;
    const double next = std::clamp(now - off * (now - before) / (off - off_before), -most, most);
    before = now, off_before = off, now = next;
  }
  return now;
}

/// Shape function gradients at the ten nodes and, between each corner and the centroid, at the four
/// integration points.
std::array<std::array<Vec3d, 10>, 14> slopes_of_element() {
  constexpr double kNear = 0.58541019662496845446, kFar = 0.13819660112501051518;  // (5 ± 3√5, −√5)/20
  std::array<std::array<Vec3d, 10>, 14> all;
  for (std::size_t c = 0; c < 4; c++) {
    std::array<double, 4> corner{}, inside{kFar, kFar, kFar, kFar};
    corner[c] = 1, inside[c] = kNear;
    all[c] = quadratic_slopes(corner), all[10 + c] = quadratic_slopes(inside);
  }
  for (std::size_t e = 0; e < kTetEdges.size(); e++) {
    std::array<double, 4> middle{};
    for (const int c : kTetEdges[e]) middle[std::size_t(c)] = 0.5;
    all[4 + e] = quadratic_slopes(middle);
  }
  return all;
}

/// Volume of the tetrahedron with straight edges [m³].
double flat_volume(const SolidMesh& mesh, std::size_t e) {
  const auto x = [&](std::size_t c) { return mesh.vertices[std::size_t(element(mesh, e)[c])]; };
  return orientation(x(0), x(1), x(2), x(3)) / 6;
}

}  // namespace

double least_map_volume(const SolidMesh& quadratic, std::size_t e) {
  static const auto kSlopes = slopes_of_element();
  const auto nodes = element(quadratic, e);
  double least = HUGE_VAL;
  for (const auto& slope : kSlopes) {
    Mat3d map{{{}, {}, {}}};
    for (std::size_t c = 0; c < 10; c++)
      for (int axis = 0; axis < 3; axis++)
        map.column[axis] += quadratic.vertices[std::size_t(nodes[c])] * slope[c][axis];
    least = std::min(least, determinant(map) / 6);
  }
  return least;
}

void curve_sides(const Exec& exec, SolidMesh& quadratic, const std::function<double(Vec3d)>& distance) {
  TURGOR_ASSERT(quadratic.corners == 10, "sides with middles are curved");
  std::vector<OuterMiddle> middles = outer_middles(quadratic);
  parallel_for(
      exec, middles.size(),
      [&](std::size_t i) { middles[i].shift = shift_to_surface(quadratic, middles[i], distance); }, 16);
  const std::vector<Vec3d> flat = quadratic.vertices;
  std::vector<int> index(flat.size(), -1);  // of each node in `middles`
  for (std::size_t i = 0; i < middles.size(); i++) index[std::size_t(middles[i].node)] = int(i);
  constexpr int kPasses = 8;  // the moves are halved in each pass and are zero in the last
  for (int pass = 0; pass <= kPasses; pass++) {
    for (const OuterMiddle& m : middles)
      quadratic.vertices[std::size_t(m.node)] = flat[std::size_t(m.node)] + m.normal * m.shift;
    std::vector<std::uint8_t> too_far(middles.size(), 0);
    for (std::size_t e = 0; e < element_count(quadratic); e++) {
      if (least_map_volume(quadratic, e) >= kLeastOfFlat * flat_volume(quadratic, e)) continue;
      for (const int node : element(quadratic, e))
        if (const int i = index[std::size_t(node)]; i >= 0) too_far[std::size_t(i)] = 1;
    }
    for (std::size_t i = 0; i < middles.size(); i++)
      if (too_far[i]) middles[i].shift *= pass + 1 < kPasses ? 0.5 : 0;
  }
}

}  // namespace turgor
