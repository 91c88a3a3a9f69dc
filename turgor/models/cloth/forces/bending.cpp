#include "turgor/models/cloth/forces/bending.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/springs.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

/// Contribution of an edge to the curvature: the change of slope J_e as a linear form of four vertices, and
/// the tensor ½ |e| n_e n_eᵀ along warp and weft.
struct Fold {
  std::array<int, 4> vertex;     // ends of the edge, then the facing corners
  std::array<double, 4> weight;  // coefficients of J_e [1/m]
  std::array<double, 3> tensor;  // ½ |e| n nᵀ: warp, weft, √2 warp-weft [m]
};

struct Sheets {
  const TriMesh& mesh;
  const Fabric& fabric;
  std::span<const char> is_sliver;  // of each triangle

  Vec3d at(int v) const { return Vec3d(mesh.vertices[std::size_t(v)]); }
  int facing(const EdgeUse& use) const {
    return mesh.triangles[std::size_t(use.triangle)][(use.side + 2) % 3];
  }
  /// Normal of the n-th triangle of an edge, oriented like that of the first.
  Vec3d normal(std::span<const EdgeUse> edge, std::size_t n) const {
    const auto [a, b, c] = mesh.triangles[std::size_t(edge[n].triangle)];
    const bool is_turned = n > 0 && edge[n].forward == edge[0].forward;
    return cross(at(b) - at(a), at(c) - at(a)) * (is_turned ? -1.0 : 1.0);
  }
};

/// Edges of two triangles that are not folded by more than 90° at rest resist bending. Those of a seam or a
/// sliver turn freely.
bool bends(const Sheets& sheets, std::span<const EdgeUse> edge) {
  for (const EdgeUse& use : edge)
    if (sheets.is_sliver[std::size_t(use.triangle)]) return false;
  return edge.size() == 2 && sheets.facing(edge[0]) != sheets.facing(edge[1]) &&
         dot(sheets.normal(edge, 0), sheets.normal(edge, 1)) > 0;
}

/// J_e = Σ w_k · x_k: with u_p, u_q the heights of the facing corners over the edge and a_p, a_q their foot
/// points (0 at a, 1 at b), w = (−(1−a_p)/u_p − (1−a_q)/u_q, −a_p/u_p − a_q/u_q, 1/u_p, 1/u_q).
Fold fold_at(const Sheets& sheets, std::span<const EdgeUse> edge) {
  const int a = edge[0].a, b = edge[0].b, p = sheets.facing(edge[0]), q = sheets.facing(edge[1]);
  // heights and foot points of the facing corners
  const Vec3d side = sheets.at(b) - sheets.at(a), along = normalized(side);
  const double length = norm(side);
  TURGOR_CHECK(length > 0, "a folded edge has a length");
  const Vec3d to_p = sheets.at(p) - sheets.at(a), to_q = sheets.at(q) - sheets.at(a);
  const double up = norm(cross(to_p, along)), uq = norm(cross(to_q, along));
  const double ap = dot(to_p, along) / length, aq = dot(to_q, along) / length;
  // mean tensor of both triangles: their weaves may be opposite, where the warp is normal to the cloth
  std::array<double, 3> tensor{};
  for (std::size_t n = 0; n < 2; n++) {
    const Weave weave = weave_at(sheets.fabric.direction, sheets.normal(edge, n));
    const double x = dot(along, weave.warp), y = dot(along, weave.weft), quarter = length / 4;
    tensor[0] += y * y * quarter, tensor[1] += x * x * quarter;
    tensor[2] -= std::sqrt(2.0) * x * y * quarter;
  }
  TURGOR_CHECK(up > 0 && uq > 0, "the triangles of a fold have areas");
  return {{a, b, p, q}, {-(1 - ap) / up - (1 - aq) / uq, -ap / up - aq / uq, 1 / up, 1 / uq}, tensor};
}

/// Voronoi areas of the vertices. An obtuse triangle gives half of its area to the obtuse corner and a
/// quarter to each other [Meyer et al. 2003]. With these areas a bent sheet has the same curvature at
/// vertices of any valence.
std::vector<double> vertex_areas(const Sheets& sheets) {
  std::vector<double> areas(sheets.mesh.vertices.size(), 0);
  for (const Int3 t : sheets.mesh.triangles) {
    double square[3],
        cotangent[3];  // squared length of the side facing each corner, and cotangent of its angle
    const double area = norm(cross(sheets.at(t.y) - sheets.at(t.x), sheets.at(t.z) - sheets.at(t.x))) / 2;
    for (int k = 0; k < 3; k++) {
      const Vec3d side = sheets.at(t[(k + 2) % 3]) - sheets.at(t[(k + 1) % 3]);
      square[k] = dot(side, side);
    }
    // cotangents from the law of cosines
    const double sum = square[0] + square[1] + square[2];
    TURGOR_CHECK(area > 0, "a triangle has an area");
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

/// Curvature tensor at a vertex as a linear form of positions [1/m²]: coefficients of warp, weft, √2
/// warp-weft per vertex.
struct Curvature {
  int vertex = 0;
  std::array<double, 3> weight{};
};
std::vector<Curvature> curvature(const std::vector<Fold>& folds, std::span<const int> around, double area) {
  TURGOR_CHECK(area > 0, "a vertex has an area");
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

std::vector<Spring> bending_weights(const TriMesh& mesh, const Fabric& fabric,
                                    std::span<const char> is_sliver) {
  TURGOR_ASSERT(is_sliver.size() == mesh.triangles.size(), "every triangle is a sliver or not");
  const double warp = fabric.rigidity_warp, weft = fabric.rigidity_weft;
  std::vector<Spring> springs;
  if (warp == 0 && weft == 0) return springs;
  // folds of all edges, and the folds around each vertex
  const Sheets sheets{mesh, fabric, is_sliver};
  std::vector<Fold> folds;
  std::vector<std::vector<int>> around(mesh.vertices.size());
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (!bends(sheets, edge)) return;
    for (const int v : {edge[0].a, edge[0].b}) around[std::size_t(v)].push_back(int(folds.size()));
    folds.push_back(fold_at(sheets, edge));
  });
  // pair weights −A_i H_i : B H_i of each vertex
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

// The sum of |Q| over a row bounds its eigenvalues, and half of it is a sufficient diagonal for Jacobi's
// method. The diagonal entry of a row is the sum of its weights.
std::vector<double> missing_diagonal(const std::vector<Spring>& springs, int count) {
  std::vector<double> sum(std::size_t(count), 0), size(std::size_t(count), 0);
  for (const Spring& s : springs)
    for (const int v : {s.a, s.b})
      sum[std::size_t(v)] += double(s.bend), size[std::size_t(v)] += std::abs(double(s.bend));
  for (std::size_t v = 0; v < sum.size(); v++) sum[v] = std::max(0.0, (size[v] + sum[v]) / 2 - sum[v]);
  return sum;
}

}  // namespace turgor::cloth
