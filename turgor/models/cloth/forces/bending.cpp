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

using SheetTensor = std::array<double, 3>;     // symmetric: warp, weft, √2 warp-weft
using TensorMap = std::array<SheetTensor, 3>;  // linear map of such tensors, by rows

/// Contribution of an edge to the curvature: the change of slope J_e as a linear form of four vertices, and
/// the tensor ½ |e| n_e n_eᵀ along warp and weft.
struct Fold {
  std::array<int, 4> vertex;     // ends of the edge, then the facing corners
  std::array<double, 4> weight;  // coefficients of J_e [1/m]
  SheetTensor tensor;            // ½ |e| n nᵀ [m]
  SheetTensor slope;             // J_e of a sheet with a curvature, as a linear form of that [m]
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
  TURGOR_CHECK(up > 0 && uq > 0, "the triangles of a fold have areas");
  // J_e of the heights ½ κ_tt t² + κ_tn t n + ½ κ_nn n² over the unrolled triangles
  const double tt = length * length / 2 * (ap * (ap - 1) / up + aq * (aq - 1) / uq), tn = length * (ap - aq),
               nn = (up + uq) / 2;
  // mean of both triangles: their weaves may be opposite, where the warp is normal to the cloth
  SheetTensor tensor{}, slope{};
  for (std::size_t k = 0; k < 2; k++) {
    const Weave weave = weave_at(sheets.fabric.direction, sheets.normal(edge, k));
    const Vec3d side_normal = k == 0 ? to_p - along * (ap * length) : along * (aq * length) - to_q,
                across = normalized(side_normal);
    const double x = dot(along, weave.warp), y = dot(along, weave.weft), quarter = length / 4;
    const double nx = dot(across, weave.warp), ny = dot(across, weave.weft), root = std::sqrt(2.0);
    tensor[0] += y * y * quarter, tensor[1] += x * x * quarter, tensor[2] -= root * x * y * quarter;
    slope[0] += (tt * x * x + tn * x * nx + nn * nx * nx) / 2;
    slope[1] += (tt * y * y + tn * y * ny + nn * ny * ny) / 2;
    slope[2] += (tt * root * x * y + tn * (x * ny + y * nx) / root + nn * root * nx * ny) / 2;
  }
  return {{a, b, p, q}, {-(1 - ap) / up - (1 - aq) / uq, -ap / up - aq / uq, 1 / up, 1 / uq}, tensor, slope};
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

/// Area times the curvature tensor at a vertex, as a linear form of positions [1]: coefficients of a vertex.
struct Curvature {
  int vertex = 0;
  SheetTensor weight{};
};
std::vector<Curvature> curvature(const std::vector<Fold>& folds, std::span<const int> around) {
  std::vector<Curvature> sums;
  for (const int f : around) {
    const Fold& fold = folds[std::size_t(f)];
    for (std::size_t k = 0; k < 4; k++) {
      const auto at = std::find_if(sums.begin(), sums.end(),
                                   [&](const Curvature& c) { return c.vertex == fold.vertex[k]; });
      Curvature& sum = at != sums.end() ? *at : sums.emplace_back(Curvature{fold.vertex[k], {}});
      for (std::size_t d = 0; d < 3; d++) sum.weight[d] += fold.weight[k] * fold.tensor[d];
    }
  }
  return sums;
}

/// Inverse of a 3×3 matrix, not finite if that is singular.
TensorMap inverse(const TensorMap& m) {
  const auto minor = [&m](std::size_t r, std::size_t c) {
    const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  TensorMap result;
  for (std::size_t r = 0; r < 3; r++)
    for (std::size_t c = 0; c < 3; c++) result[r][c] = minor(c, r) / determinant;
  return result;
}

/// True if a symmetric matrix is positive definite.
bool is_positive(const TensorMap& m) {
  const double minor = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  const double determinant = m[2][2] * minor - m[2][0] * (m[1][1] * m[0][2] - m[0][1] * m[1][2]) +
                             m[2][1] * (m[1][0] * m[0][2] - m[0][0] * m[1][2]);
  return m[0][0] > 0 && minor > 0 && determinant > 0;
}

/// Stiffness S of a vertex, E_i = ½ b : S b with b = Σ ½ |e| J_e n nᵀ. B/A_i, if any of its edges does not
/// bend. Inside, A_i is replaced by the tensor Σ ½ |e| n nᵀ ⊗ ∂J_e/∂κ, which makes b that of a sheet with
/// the curvature κ exactly A_i κ on every mesh. Its result must be within a factor of four of B/A_i.
TensorMap vertex_stiffness(const std::vector<Fold>& folds, std::span<const int> around, bool is_inside,
                           double area, const SheetTensor& rigidity) {
  TURGOR_CHECK(area > 0, "a vertex has an area");
  TensorMap simple{};
  for (std::size_t d = 0; d < 3; d++) simple[d][d] = rigidity[d] / area;
  if (!is_inside || !(rigidity[0] > 0 && rigidity[1] > 0)) return simple;
  // tensor of areas
  TensorMap areas{};
  for (const int f : around)
    for (std::size_t r = 0; r < 3; r++)
      for (std::size_t c = 0; c < 3; c++)
        areas[r][c] += folds[std::size_t(f)].tensor[r] * folds[std::size_t(f)].slope[c];
  // symmetric part of B A⁻¹, and its bounds
  const TensorMap per_area = inverse(areas);
  TensorMap stiffness{}, above{}, below{};
  for (std::size_t r = 0; r < 3; r++)
    for (std::size_t c = 0; c < 3; c++) {
      stiffness[r][c] = (rigidity[r] * per_area[r][c] + rigidity[c] * per_area[c][r]) / 2;
      above[r][c] = stiffness[r][c] - simple[r][c] / 4, below[r][c] = 4 * simple[r][c] - stiffness[r][c];
    }
  return is_positive(above) && is_positive(below) ? stiffness : simple;
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
  std::vector<char> is_inside(mesh.vertices.size(), 1);
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    const bool is_fold = bends(sheets, edge);
    for (const int v : {edge[0].a, edge[0].b})
      if (is_fold)
        around[std::size_t(v)].push_back(int(folds.size()));
      else
        is_inside[std::size_t(v)] = 0;
    if (is_fold) folds.push_back(fold_at(sheets, edge));
  });
  // pair weights −b_i : S b_i of each vertex
  const std::vector<double> areas = vertex_areas(sheets);
  const SheetTensor rigidity{warp, weft, std::sqrt(warp * weft)};
  for (std::size_t v = 0; v < around.size(); v++) {
    if (around[v].empty()) continue;
    const std::vector<Curvature> sums = curvature(folds, around[v]);
    const TensorMap stiffness = vertex_stiffness(folds, around[v], is_inside[v] != 0, areas[v], rigidity);
    for (std::size_t m = 0; m < sums.size(); m++)
      for (std::size_t n = m + 1; n < sums.size(); n++) {
        double form = 0;
        for (std::size_t r = 0; r < 3; r++)
          for (std::size_t c = 0; c < 3; c++) form += sums[m].weight[r] * stiffness[r][c] * sums[n].weight[c];
        const int i = sums[m].vertex, j = sums[n].vertex;
        springs.push_back({.a = std::min(i, j), .b = std::max(i, j), .bend = Real(-form)});
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
