#include "turgor/models/cloth/build/check_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

namespace {

/// Height over the longest side, relative to that side.
double slenderness(Vec3d a, Vec3d b, Vec3d c) {
  const double longest2 = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
  return longest2 > 0 ? norm(cross(b - a, c - a)) / longest2 : 0;
}

Status check_triangles(const TriMesh& mesh) {
  constexpr double kFlat = 1e-6;  // relative height below the resolution of single precision
  std::vector<int> flat;
  for (std::size_t t = 0; t < mesh.triangles.size(); t++) {
    const auto [a, b, c] = mesh.triangles[t];
    const auto at = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
    if (!(slenderness(at(a), at(b), at(c)) > kFlat)) flat.push_back(int(t));
  }
  if (flat.empty()) return Done{};
  return Error{"expected triangles with an area, found none in " + named("triangle", "triangles", flat)};
}

}  // namespace

std::string named(const std::string& one, const std::string& many, const std::vector<int>& ids) {
  constexpr std::size_t kShown = 5;
  std::string text = ids.size() == 1 ? one : many;
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); i++)
    text += (i == 0 ? " " : ", ") + std::to_string(ids[i]);
  if (ids.size() > kShown) text += " and " + std::to_string(ids.size() - kShown) + " more";
  return text;
}

Status check_mesh(const TriMesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  if (mesh.triangles.empty()) return Error{"the mesh has no triangle"};
  // vertices of triangles
  std::vector<std::uint8_t> used(count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) {
      const int v = mesh.triangles[t][corner];
      if (v < 0 || std::size_t(v) >= count)
        return Error{"triangle " + std::to_string(t) + " has vertex " + std::to_string(v) +
                     ", expected 0 to " + std::to_string(count - 1)};
      used[std::size_t(v)] = 1;
    }
  // invalid vertices
  std::vector<int> strange, unused;
  for (std::size_t v = 0; v < count; v++) {
    if (!is_finite(mesh.vertices[v])) strange.push_back(int(v));
    if (!used[v]) unused.push_back(int(v));
  }
  if (!strange.empty())
    return Error{"expected finite coordinates, found others in " + named("vertex", "vertices", strange)};
  if (!unused.empty())
    return Error{
        "expected every vertex in a triangle, since it has no mass otherwise; found no triangle of " +
        named("vertex", "vertices", unused)};
  return check_triangles(mesh);
}

Status check_params(const Params& params) {
  struct Number {
    const char* name;
    double value;
    bool may_be_zero;
    const char* unit;
  };
  const auto& [fabric, damping, solver, collision, weld] = params;
  // ranges of numbers
  for (const auto& [name, value, may_be_zero, unit] :
       {Number{"density", fabric.density, false, " kg/m²"}, Number{"warp", fabric.warp, false, " N/m"},
        Number{"weft", fabric.weft, false, " N/m"}, Number{"shear", fabric.shear, true, " N/m"},
        Number{"bend", fabric.bend, true, " N/m"}, Number{"poisson", fabric.poisson, true, ""},
        Number{"rigidity_warp", fabric.rigidity_warp, true, " N·m"},
        Number{"rigidity_weft", fabric.rigidity_weft, true, " N·m"},
        Number{"damping.motion", damping.motion, true, " 1/s"},
        Number{"damping.stretch", damping.stretch, true, " s"},
        Number{"strain limit", solver.strain_limit, true, ""},
        Number{"thickness", collision.thickness, false, " m"},
        Number{"friction", collision.friction, true, ""}, Number{"weld", weld, true, " m"}})
    if (!std::isfinite(value) || value < 0 || (value == 0 && !may_be_zero))
      return Error{std::string(name) + ": expected a number " + (may_be_zero ? "not below" : "above") + " 0" +
                   unit + ", found " + number_text(value)};
  // other conditions
  if (!(fabric.poisson * fabric.poisson * fabric.weft < fabric.warp))
    return Error{"poisson: expected less than " + number_text(std::sqrt(fabric.warp / fabric.weft)) +
                 ", the root of warp over weft, found " + number_text(fabric.poisson)};
  if (solver.sweeps < 1) return Error{"sweeps: expected 1 or more, found " + std::to_string(solver.sweeps)};
  if (collision.iterations < 1)
    return Error{"iterations: expected 1 or more, found " + std::to_string(collision.iterations)};
  if (!(norm(fabric.direction) > 0)) return Error{"direction: expected a vector that is not zero"};
  return Done{};
}

namespace {

struct FoundEdges {
  int count = 0;
  std::string where;  // list such as "(5-6, 8-9, …)"
};
template <class Is>
FoundEdges find_edges(const TriMesh& mesh, const Is& is) {
  FoundEdges found;
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (!is(edge)) return;
    if (found.count++ < 5)
      found.where +=
          (found.count > 1 ? ", " : "(") + std::to_string(edge[0].a) + "-" + std::to_string(edge[0].b);
  });
  found.where += found.count > 5 ? ", …)" : ")";
  return found;
}

/// Unit vector from an edge to the third corner of a triangle, perpendicular to the edge.
Vec3d away_from(const TriMesh& mesh, const EdgeUse& edge) {
  const auto at = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
  const Vec3d along = normalized(at(edge.b) - at(edge.a));
  const Vec3d away = at(mesh.triangles[std::size_t(edge.triangle)][(edge.side + 2) % 3]) - at(edge.a);
  return normalized(away - along * dot(away, along));
}

}  // namespace

std::string crowded_edges(const TriMesh& mesh) {
  const FoundEdges crowded = find_edges(mesh, [](std::span<const EdgeUse> edge) { return edge.size() > 2; });
  if (crowded.count == 0) return "";
  return (crowded.count == 1 ? std::string("1 edge belongs")
                             : std::to_string(crowded.count) + " edges belong") +
         " to more than two triangles " + crowded.where;
}

std::string folded_edges(const TriMesh& mesh) {
  constexpr double kDegree = std::numbers::pi / 180;
  const FoundEdges folded = find_edges(mesh, [&](std::span<const EdgeUse> edge) {
    return edge.size() == 2 && norm(away_from(mesh, edge[0]) - away_from(mesh, edge[1])) < kDegree;
  });
  if (folded.count == 0) return "";
  return (folded.count == 1 ? std::string("1 edge is") : std::to_string(folded.count) + " edges are") +
         " folded flat " + folded.where;
}

TriMesh welded(const TriMesh& mesh, double distance, std::vector<int>& vertex) {
  TURGOR_CHECK(distance > 0, "vertices merge within a distance");
  // spatial hash
  const int count = int(mesh.vertices.size());
  Vectors points;
  points.resize(std::size_t(count));
  for (int v = 0; v < count; v++) points.set(std::size_t(v), mesh.vertices[std::size_t(v)]);
  SpatialHash near;
  sort_points(Exec(1), points, count, Real(2.1 * distance), near);
  // each vertex joins the near one with the smallest number
  TriMesh result;
  vertex.assign(std::size_t(count), -1);
  for (int v = 0; v < count; v++) {
    int first = v;
    const Vec3 p = points[std::size_t(v)];
    visit_near(near, p, Real(distance), [&](int other, Vec3) { first = std::min(first, other); });
    if (first < v) {
      vertex[std::size_t(v)] = vertex[std::size_t(first)];
      continue;
    }
    vertex[std::size_t(v)] = int(result.vertices.size());
    result.vertices.push_back(p);
  }
  TURGOR_CHECK(all_indices(vertex, result.vertices.size()),
               "every vertex is kept or merged into one before it");
  // triangles that keep their area
  for (const auto [a, b, c] : mesh.triangles) {
    const Int3 t{vertex[std::size_t(a)], vertex[std::size_t(b)], vertex[std::size_t(c)]};
    if (t.x != t.y && t.y != t.z && t.z != t.x) result.triangles.push_back(t);
  }
  return result;
}

}  // namespace turgor::cloth
