#include "turgor/models/sfem/inner_green.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/element_coordinates.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

int index_in(const std::vector<int>& ascending, int value) {
  const auto at = std::lower_bound(ascending.begin(), ascending.end(), value);
  return at != ascending.end() && *at == value ? int(at - ascending.begin()) : -1;
}

/// Vertices, corners, material and surface of the elements.
void describe_elements(const Model& model, InnerGreen& inner) {
  const SolidMesh& mesh = model.body.mesh;
  inner.corners = mesh.corners;
  // vertices
  for (const int e : inner.elements)
    for (const int v : element(mesh, std::size_t(e))) inner.vertices.push_back(v);
  sort_unique(inner.vertices);
  for (const int v : inner.vertices) inner.x.push_back(mesh.vertices[std::size_t(v)]);
  // corners, stiffness and size
  const std::vector<int> material = element_materials(model.body);
  for (const int e : inner.elements) {
    for (const int v : element(mesh, std::size_t(e))) inner.corner.push_back(index_in(inner.vertices, v));
    const Material& own = model.body.materials[std::size_t(material[std::size_t(e)])];
    inner.material.push_back(material[std::size_t(e)]);
    inner.shear.push_back(moduli(own).shear), inner.poisson.push_back(own.poisson);
    inner.size.push_back(std::cbrt(std::abs(volume(mesh, std::size_t(e)))));
  }
  // surface of the body
  for (std::size_t t = 0; t < model.surface.triangles.size(); t++) {
    const int behind = index_in(inner.elements, model.surface.element[t]);
    if (behind < 0) continue;
    const Int3 corners = model.surface.triangles[t];
    inner.surface.push_back({index_in(inner.vertices, corners.x), index_in(inner.vertices, corners.y),
                             index_in(inner.vertices, corners.z)});
    inner.behind.push_back(behind);
  }
}

/// Solves the columns of these free vertices (indices into InnerGreen::vertices) and stores their blocks.
void solve_columns(const Model& model, std::span<const int> free, std::size_t first, std::size_t last,
                   std::span<const unsigned char> wanted, InnerGreen& inner) {
  const Elimination& plan = model.factor->plan;
  const auto row_of = [&](int i) { return model.free_node[std::size_t(inner.vertices[std::size_t(i)])]; };
  std::vector<int> rows;
  for (std::size_t i = first; i < last; i++) rows.push_back(row_of(free[i]));
  UnitSolutions solved;
  solve_units(*model.factor, rows, wanted, 0, solved);
  const std::size_t count = inner.vertices.size();
  for (const int row : free) {
    const double* values = solved.row(plan.position[std::size_t(row_of(row))]);
    for (std::size_t c = first; c < last; c++) {
      float* block = &inner.green[9 * (std::size_t(row) * count + std::size_t(free[c]))];
      for (std::size_t j = 0; j < 3; j++)
        for (std::size_t i = 0; i < 3; i++)
          block[3 * j + i] = float(values[i * solved.columns + 3 * (c - first) + j]);
    }
  }
}

/// Makes Ξ exactly symmetric: rounding differs between the columns of two vertices.
void symmetrize(InnerGreen& inner) {
  const std::size_t n = inner.vertices.size();
  for (std::size_t a = 0; a < n; a++)
    for (std::size_t b = 0; b <= a; b++)
      for (std::size_t k = 0; k < 9; k++)
        inner.green[9 * (b * n + a) + k] = inner.green[9 * (a * n + b) + k % 3 * 3 + k / 3];
}

/// Positions of the first corners of an element.
template <std::size_t kCount>
std::array<Vec3d, kCount> corner_positions(const InnerGreen& inner, int e) {
  std::array<Vec3d, kCount> x;
  for (std::size_t c = 0; c < kCount; c++)
    x[c] = inner.x[std::size_t(inner.corner[std::size_t(e) * std::size_t(inner.corners) + c])];
  return x;
}

/// Weights of a position in one element; `outside`: see inner_point.
InnerPoint point_in(const InnerGreen& inner, int e, Vec3d p, double& outside) {
  InnerPoint point{.element = e};
  if (inner.corners == 8) {
    const Vec3d s = hex_coordinates(corner_positions<8>(inner, e), p);
    outside = 0;
    for (int axis = 0; axis < 3; axis++) outside = std::max({outside, -s[axis], s[axis] - 1});
    std::array<Vec3d, 8> gradient{};
    trilinear(s, std::span(point.weight).first<8>(), gradient);
    return point;
  }
  const std::array<double, 4> linear = tet_coordinates(corner_positions<4>(inner, e), p);
  outside = std::max(0.0, -*std::min_element(linear.begin(), linear.end()));
  if (inner.corners == 10)
    point.weight = quadratic_weights(linear);
  else
    std::copy(linear.begin(), linear.end(), point.weight.begin());
  return point;
}

}  // namespace

std::size_t inner_green_bytes(std::size_t vertices) { return 9 * sizeof(float) * vertices * vertices; }

InnerGreen make_inner_green(const Exec& exec, const Model& model, std::vector<int> elements,
                            const Progress& progress) {
  constexpr std::size_t kTogether = 16;  // vertices whose columns are solved together
  TURGOR_ASSERT(model.factor.has_value(), "Green's functions inside are solved from the factor");
  InnerGreen inner;
  inner.elements = std::move(elements);
  describe_elements(model, inner);
  // columns of the free vertices; fixed ones do not move
  std::vector<int> free, rows;
  for (std::size_t i = 0; i < inner.vertices.size(); i++)
    if (const int row = model.free_node[std::size_t(inner.vertices[i])]; row >= 0)
      free.push_back(int(i)), rows.push_back(row);
  inner.green.assign(9 * inner.vertices.size() * inner.vertices.size(), 0);
  const std::vector<unsigned char> wanted = with_ancestors(model.factor->plan, rows);
  const std::size_t blocks = (free.size() + kTogether - 1) / kTogether;
  parallel_for(exec, blocks, [&](std::size_t block) {
    const std::size_t first = block * kTogether, last = std::min(free.size(), first + kTogether);
    solve_columns(model, free, first, last, wanted, inner);
  });
  symmetrize(inner);
  if (progress) progress(1);
  return inner;
}

InnerPoint inner_point(const InnerGreen& inner, Vec3d rest, int first, double& outside) {
  TURGOR_CHECK(!inner.elements.empty(), "a point is inside of an element");
  constexpr double kInside = 1e-9;
  InnerPoint best;
  outside = HUGE_VAL;
  const auto consider = [&](int e) {
    double beyond = 0;
    const InnerPoint point = point_in(inner, e, rest, beyond);
    if (beyond < outside) best = point, outside = beyond;
    return outside <= kInside;
  };
  if (first >= 0 && consider(first)) return outside = 0, best;
  for (std::size_t e = 0; e < inner.elements.size(); e++) {
    // elements that are far away
    const int* corner = &inner.corner[e * std::size_t(inner.corners)];
    const Vec3d d = inner.x[std::size_t(corner[0])] - rest;
    const double reach = 4 * inner.size[e];
    if (dot(d, d) > reach * reach) continue;
    if (consider(int(e))) return outside = 0, best;
  }
  // nothing near: extrapolated from any element
  if (best.element < 0) consider(0);
  return best;
}

ComplianceBlock compliance_between(const InnerGreen& inner, const InnerPoint& p, const InnerPoint& q) {
  const auto corners = std::size_t(inner.corners), count = inner.vertices.size();
  const int *row = &inner.corner[std::size_t(p.element) * corners],
            *column = &inner.corner[std::size_t(q.element) * corners];
  ComplianceBlock sum{};
  for (std::size_t a = 0; a < corners; a++)
    for (std::size_t b = 0; b < corners; b++) {
      const float* block = &inner.green[9 * (std::size_t(row[a]) * count + std::size_t(column[b]))];
      const double w = p.weight[a] * q.weight[b];
      for (std::size_t k = 0; k < 9; k++) sum[k] += w * double(block[k]);
    }
  return sum;
}

void compliance_row(const InnerGreen& inner, const InnerPoint& p, std::span<double> row) {
  const auto corners = std::size_t(inner.corners), count = 9 * inner.vertices.size();
  TURGOR_CHECK(row.size() == count, "a row has a block for every vertex");
  std::fill(row.begin(), row.end(), 0.0);
  double* out = row.data();
  for (std::size_t a = 0; a < corners; a++) {
    const auto vertex = std::size_t(inner.corner[std::size_t(p.element) * corners + a]);
    const float* blocks = &inner.green[vertex * count];
    const double w = p.weight[a];
    TURGOR_LANES
    for (std::size_t i = 0; i < count; i++) out[i] += w * double(blocks[i]);
  }
}

ComplianceBlock compliance_in_row(const InnerGreen& inner, std::span<const double> row, const InnerPoint& q) {
  const auto corners = std::size_t(inner.corners);
  ComplianceBlock sum{};
  for (std::size_t b = 0; b < corners; b++) {
    const double* block = &row[9 * std::size_t(inner.corner[std::size_t(q.element) * corners + b])];
    for (std::size_t k = 0; k < 9; k++) sum[k] += q.weight[b] * block[k];
  }
  return sum;
}

std::array<Vec3d, 10> corner_displacements(const InnerGreen& inner, int element,
                                           std::span<const Vec3d> forces) {
  const auto corners = std::size_t(inner.corners), count = inner.vertices.size();
  std::array<Vec3d, 10> u{};
  for (std::size_t v = 0; v < count; v++) {
    const Vec3d f = forces[v];
    if (f == Vec3d{}) continue;
    for (std::size_t a = 0; a < corners; a++) {
      const auto vertex = std::size_t(inner.corner[std::size_t(element) * corners + a]);
      const float* c = &inner.green[9 * (vertex * count + v)];
      for (int axis = 0; axis < 3; axis++)
        u[a][axis] += double(c[axis]) * f.x + double(c[3 + axis]) * f.y + double(c[6 + axis]) * f.z;
    }
  }
  return u;
}

Vec3d at_point(const InnerGreen& inner, const InnerPoint& p, std::span<const Vec3d> of_vertices) {
  const auto corners = std::size_t(inner.corners);
  Vec3d sum;
  for (std::size_t c = 0; c < corners; c++)
    sum += of_vertices[std::size_t(inner.corner[std::size_t(p.element) * corners + c])] * p.weight[c];
  return sum;
}

void add_force(const InnerGreen& inner, const InnerPoint& p, Vec3d force, std::span<Vec3d> of_vertices) {
  const auto corners = std::size_t(inner.corners);
  for (std::size_t c = 0; c < corners; c++)
    of_vertices[std::size_t(inner.corner[std::size_t(p.element) * corners + c])] += force * p.weight[c];
}

}  // namespace turgor::sfem
