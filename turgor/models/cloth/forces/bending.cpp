#include "turgor/models/cloth/forces/bending.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/springs.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

namespace {

/// A fold: how the slope across an edge changes, as a sum over four vertices, times half of its length, as a
/// tensor along warp and weft.
struct Fold {
  std::array<int, 4> vertex;     // of the edge, then facing it
  std::array<double, 4> weight;  // of the change of slope [1/m]
  std::array<double, 3> tensor;  // n nᵀ: warp, weft, √2 both, times half of the edge's length [m]
};

struct Sheets {
  const TriMesh& mesh;
  const Fabric& fabric;

  Vec3d at(int v) const { return Vec3d(mesh.vertices[std::size_t(v)]); }
  int facing(const EdgeUse& use) const {
    return mesh.triangles[std::size_t(use.triangle)][(use.side + 2) % 3];
  }
  /// Of a triangle of an edge, turned so that the first and the second of them lie alike.
  Vec3d normal(std::span<const EdgeUse> edge, std::size_t n) const {
    const auto [a, b, c] = mesh.triangles[std::size_t(edge[n].triangle)];
    const bool is_turned = n > 0 && edge[n].forward == edge[0].forward;
    return cross(at(b) - at(a), at(c) - at(a)) * (is_turned ? -1.0 : 1.0);
  }
};

/// Edges of two triangles that are not folded back at rest: those of a seam turn freely.
bool bends(const Sheets& sheets, std::span<const EdgeUse> edge) {
  return edge.size() == 2 && sheets.facing(edge[0]) != sheets.facing(edge[1]) &&
         dot(sheets.normal(edge, 0), sheets.normal(edge, 1)) > 0;
}

Fold fold_at(const Sheets& sheets, std::span<const EdgeUse> edge) {
  const int a = edge[0].a, b = edge[0].b, p = sheets.facing(edge[0]), q = sheets.facing(edge[1]);
  const Vec3d way = sheets.at(b) - sheets.at(a), along = normalized(way);
  const double length = norm(way);
  const Vec3d to_p = sheets.at(p) - sheets.at(a), to_q = sheets.at(q) - sheets.at(a);
  const double up = norm(cross(to_p, along)), uq = norm(cross(to_q, along));
  const double ap = dot(to_p, along) / length, aq = dot(to_q, along) / length;
  double x = 0, y = 0;  // the edge by warp and weft, seen from both sides
  for (std::size_t n = 0; n < 2; n++) {
    const Weave weave = weave_at(sheets.fabric.direction, sheets.normal(edge, n));
    x += dot(along, weave.warp), y += dot(along, weave.weft);
  }
  const double size = std::hypot(x, y);
  x /= size, y /= size;
  return {{a, b, p, q},
          {-(1 - ap) / up - (1 - aq) / uq, -ap / up - aq / uq, 1 / up, 1 / uq},
          {y * y * length / 2, x * x * length / 2, -std::sqrt(2.0) * x * y * length / 2}};
}

/// Voronoi's part of each vertex, and in obtuse triangles half for the obtuse corner [Meyer et al. 2003]:
/// with these, a bent sheet has the same curvature at every vertex, however many triangles meet there.
std::vector<double> vertex_areas(const Sheets& sheets) {
  std::vector<double> areas(sheets.mesh.vertices.size(), 0);
  for (const Int3 t : sheets.mesh.triangles) {
    double square[3], cotangent[3];  // of the side that faces a corner, and of its angle
    const double area = norm(cross(sheets.at(t.y) - sheets.at(t.x), sheets.at(t.z) - sheets.at(t.x))) / 2;
    for (int k = 0; k < 3; k++) {
      const Vec3d side = sheets.at(t[(k + 2) % 3]) - sheets.at(t[(k + 1) % 3]);
      square[k] = dot(side, side);
    }
    const double sum = square[0] + square[1] + square[2];
    for (int k = 0; k < 3; k++) cotangent[k] = (sum - 2 * square[k]) / (4 * area);
    const bool is_obtuse = std::min({cotangent[0], cotangent[1], cotangent[2]}) < 0;
    for (int k = 0; k < 3; k++) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      areas[std::size_t(t[k])] += is_obtuse ? area * (cotangent[k] < 0 ? 0.5 : 0.25)
                                            : (cotangent[i] * square[i] + cotangent[j] * square[j]) / 8;
    }
  }
  return areas;
}

/// The curvature at a vertex as sums over the vertices around it [1/m²]: warp, weft, √2 both.
struct Curvature {
  int vertex = 0;
  std::array<double, 3> weight{};
};
std::vector<Curvature> curvature(const std::vector<Fold>& folds, std::span<const int> around, double area) {
  std::vector<Curvature> sums;
  for (const int f : around) {
    const Fold& fold = folds[std::size_t(f)];
    for (std::size_t k = 0; k < 4; k++) {
      const auto at = std::find_if(sums.begin(), sums.end(),
                                   [&](const Curvature& c) { return c.vertex == fold.vertex[k]; });
      Curvature& sum = at != sums.end() ? *at : sums.emplace_back(Curvature{fold.vertex[k], {}});
      for (std::size_t d = 0; d < 3; d++) sum.weight[d] += fold.weight[k] * fold.tensor[d] / area;
    }
  }
  return sums;
}

}  // namespace

std::vector<Spring> bending_weights(const TriMesh& mesh, const Fabric& fabric) {
  const double warp = fabric.rigidity_warp, weft = fabric.rigidity_weft;
  std::vector<Spring> springs;
  if (warp == 0 && weft == 0) return springs;
  const Sheets sheets{mesh, fabric};
  std::vector<Fold> folds;
  std::vector<std::vector<int>> around(mesh.vertices.size());
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (!bends(sheets, edge)) return;
    for (const int v : {edge[0].a, edge[0].b}) around[std::size_t(v)].push_back(int(folds.size()));
    folds.push_back(fold_at(sheets, edge));
  });
  const std::vector<double> areas = vertex_areas(sheets);
  const double rigidity[3] = {warp, weft, std::sqrt(warp * weft)};
  for (std::size_t v = 0; v < around.size(); v++) {
    const std::vector<Curvature> sums = curvature(folds, around[v], areas[v]);
    for (std::size_t m = 0; m < sums.size(); m++)
      for (std::size_t n = m + 1; n < sums.size(); n++) {
        double form = 0;
        for (std::size_t d = 0; d < 3; d++) form += rigidity[d] * sums[m].weight[d] * sums[n].weight[d];
        const int i = sums[m].vertex, j = sums[n].vertex;
        springs.push_back({.a = std::min(i, j), .b = std::max(i, j), .bend = Real(-areas[v] * form)});
      }
  }
  merge(springs);
  return springs;
}

// |Q| summed over a row bounds its eigenvalues, so half of that is enough of a diagonal for Jacobi's method.
// A row's own entry is the sum of the weights.
std::vector<double> lacking_weight(const std::vector<Spring>& springs, int count) {
  std::vector<double> sum(std::size_t(count), 0), size(std::size_t(count), 0);
  for (const Spring& s : springs)
    for (const int v : {s.a, s.b})
      sum[std::size_t(v)] += double(s.bend), size[std::size_t(v)] += std::abs(double(s.bend));
  for (std::size_t v = 0; v < sum.size(); v++) sum[v] = std::max(0.0, (size[v] + sum[v]) / 2 - sum[v]);
  return sum;
}

}  // namespace turgor::cloth
