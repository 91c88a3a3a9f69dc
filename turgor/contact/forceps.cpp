#include "turgor/contact/forceps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor::contact {

namespace {

TriangleTree tree_of(const TriMesh& mesh) {
  std::vector<Vec3d> vertices;
  for (const Vec3 x : mesh.vertices) vertices.push_back(Vec3d(x));
  return build_triangle_tree(std::move(vertices), mesh.triangles);
}

Vec3d centroid(const TriMesh& mesh) {
  TURGOR_CHECK(!mesh.vertices.empty(), "a centroid is over at least one vertex");
  Vec3d sum;
  for (const Vec3 x : mesh.vertices) sum += Vec3d(x);
  return sum / double(mesh.vertices.size());
}

double lowest(const TriMesh& mesh) {
  double low = std::numeric_limits<double>::infinity();
  for (const Vec3 x : mesh.vertices) low = std::min(low, double(x.z));
  return low;
}
double highest(const TriMesh& mesh) {
  double high = -std::numeric_limits<double>::infinity();
  for (const Vec3 x : mesh.vertices) high = std::max(high, double(x.z));
  return high;
}

/// Index of the connected component of every vertex.
std::vector<int> connected_components(const TriMesh& mesh) {
  TURGOR_CHECK(all_indices(mesh.triangles, mesh.vertices.size()),
               "the corners of triangles are vertices of the mesh");
  // union of vertices joined by triangles
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  for (const Int3 t : mesh.triangles)
    for (const int v : {t.y, t.z}) join_sets(root, t.x, v);
  // number the components
  std::vector<int> number(root.size(), -1), component(root.size());
  int count = 0;
  for (std::size_t v = 0; v < root.size(); v++) {
    int& n = number[std::size_t(root_of(root, int(v)))];
    if (n < 0) n = count++;
    component[v] = n;
  }
  return component;
}

Status check_jaw(const TriMesh& jaw, const char* which) {
  if (jaw.triangles.empty()) return Error{std::string(which) + " jaw has no triangles"};
  for (const Vec3 x : jaw.vertices)
    if (!is_finite(x)) return Error{std::string("a vertex of ") + which + " jaw is not finite"};
  return Done{};
}

/// Smallest distance of either jaw's vertices from the other jaw [m].
double gap_between(const TriMesh& a, const TriMesh& b) {
  const TriangleTree of_a = tree_of(a), of_b = tree_of(b);
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3d x : of_a.vertices) least = std::min(least, nearest_point(of_b, x).distance);
  for (const Vec3d x : of_b.vertices) least = std::min(least, nearest_point(of_a, x).distance);
  return least;
}

/// Half the extent of both tips across the jaws and along their opening.
double tip_radius_of(const std::array<TriMesh, 2>& jaws, double tip, double length) {
  double radius = 0;
  for (const TriMesh& jaw : jaws)
    for (const Vec3 x : jaw.vertices)
      if (x.z < tip + 0.02 * length)
        radius = std::max(radius, double(std::max(std::abs(x.x), std::abs(x.y))));
  return std::max(radius, 0.005 * length);
}

}  // namespace

Result<Forceps> build_forceps(TriMesh first, TriMesh second, double opening) {
  // check the jaws; the first one is on the side of positive x
  if (const Status good = check_jaw(first, "the first"); !good) return good.error();
  if (const Status good = check_jaw(second, "the second"); !good) return good.error();
  if (centroid(first).x < centroid(second).x) std::swap(first, second);
  if (!(centroid(first).x > 0 && centroid(second).x < 0))
    return Error{"expected one jaw on each side of the plane x = 0, found both on one side"};
  // check opening and length
  const double tip = std::min(lowest(first), lowest(second));
  const double length = std::max(highest(first), highest(second)) - tip;
  if (!(opening > 0 && opening < length))
    return Error{"the opening of the jaws: expected more than 0 and less than their length of " +
                 number_text(length) + " m, found " + number_text(opening) + " m"};
  // check that the jaws meet
  if (const double gap = gap_between(first, second); gap > 0.1 * opening)
    return Error{"the jaws never meet: when closed, they are " + number_text(gap) +
                 " m apart, expected at most a tenth of the opening of " + number_text(opening) + " m"};
  // assemble
  Forceps forceps{.jaws = {std::move(first), std::move(second)}, .hinge = tip + length, .opening = opening};
  forceps.tip_radius = tip_radius_of(forceps.jaws, tip, length);
  return forceps;
}

Result<Forceps> build_forceps(const TriMesh& both, double opening) {
  // connected components, and the side of each one
  const std::vector<int> component = connected_components(both);
  const int component_count =
      component.empty() ? 0 : 1 + *std::max_element(component.begin(), component.end());
  std::vector<double> side(std::size_t(component_count), 0);
  for (std::size_t v = 0; v < component.size(); v++) side[std::size_t(component[v])] += both.vertices[v].x;
  // distribute vertices
  std::array<TriMesh, 2> jaws;
  std::vector<int> number(both.vertices.size());
  for (std::size_t v = 0; v < component.size(); v++) {
    TriMesh& jaw = jaws[side[std::size_t(component[v])] > 0 ? 0 : 1];
    number[v] = int(jaw.vertices.size());
    jaw.vertices.push_back(both.vertices[v]);
  }
  // distribute triangles
  for (const Int3 t : both.triangles) {
    TriMesh& jaw = jaws[side[std::size_t(component[std::size_t(t.x)])] > 0 ? 0 : 1];
    jaw.triangles.push_back({number[std::size_t(t.x)], number[std::size_t(t.y)], number[std::size_t(t.z)]});
  }
  return build_forceps(std::move(jaws[0]), std::move(jaws[1]), opening);
}

TriMesh forceps_mesh(const Forceps& forceps, double opening) {
  TriMesh both;
  for (std::size_t j = 0; j < 2; j++) {
    // rotate each jaw about the hinge
    const double side = j == 0 ? 1 : -1;
    const double angle = side * std::asin(std::clamp(0.5 * opening / forceps.hinge, -1.0, 1.0));
    const double c = std::cos(angle), s = std::sin(angle);
    const int first = int(both.vertices.size());
    for (const Vec3 x : forceps.jaws[j].vertices) {
      const double down = forceps.hinge - double(x.z);
      both.vertices.push_back(
          Vec3(Vec3d{c * double(x.x) + s * down, double(x.y), forceps.hinge - c * down + s * double(x.x)}));
    }
    for (const Int3 t : forceps.jaws[j].triangles)
      both.triangles.push_back({t.x + first, t.y + first, t.z + first});
  }
  return both;
}

}  // namespace turgor::contact
