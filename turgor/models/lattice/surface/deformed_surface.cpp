// Deformation of the drawn surface: every vertex is embedded in its fragment.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/surface/close_ends.hpp"
#include "turgor/models/lattice/surface/deform_surface.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"

namespace turgor::lattice {

namespace {

using detail::SurfacePlan;
using detail::VertexCorners;

constexpr std::size_t kGrain = 4096;  // vertices, corners or triangles per task

/// Plan of a surface that has none.
std::shared_ptr<const SurfacePlan> plan_of(const Exec& exec, const Model& model, const Cuts& cuts,
                                           const BodySurface& surface) {
  return surface.plan ? surface.plan : detail::make_surface_plan(exec, model, cuts, surface);
}

/// Displacement of every corner of the plan, lattice frame [m].
std::vector<Vec3> corner_displacements(const Exec& exec, const Model& model, const State& state,
                                       const BodySurface& surface, const SurfacePlan& plan) {
  std::vector<Vec3> corner_u(plan.corners.size());
  const auto move_corner = [&](std::size_t c) {
    const auto begin = std::size_t(plan.term_begin[c]), end = std::size_t(plan.term_begin[c + 1]);
    corner_u[c] = begin < end
                      ? mean_of_terms(std::span(plan.terms).subspan(begin, end - begin), state.motion.u)
                      : corner_displacement(model, state, *surface.fragments, plan.corners[c]);
  };
  parallel_for(exec, corner_u.size(), move_corner, kGrain);
  return corner_u;
}

/// Displacement of a vertex from those of its corners.
Vec3 u_of(const VertexCorners& vertex, const std::vector<Vec3>& corner_u) {
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (vertex.weight[c] != 0) sum += corner_u[std::size_t(vertex.index[c])] * vertex.weight[c];
  return sum;
}

/// Displaced vertices, lattice frame [m]. `scalars` gets the displacements of the vertices if they are shown.
std::vector<Vec3> displace(const Exec& exec, const Model& model, const State& state,
                           const BodySurface& surface, const SurfacePlan& plan, Shown shown,
                           std::vector<float>& scalars) {
  TURGOR_CHECK(plan.of_vertex.size() == surface.rest.size(), "the plan is that of the surface");
  const std::vector<Vec3> corner_u = corner_displacements(exec, model, state, surface, plan);
  std::vector<Vec3> x(surface.rest.size());
  const auto move_vertex = [&](std::size_t v) {
    const Vec3 u = u_of(plan.of_vertex[v], corner_u);
    x[v] = surface.rest[v] + u;
    if (shown == Shown::kDisplacement) scalars[v] = norm(u);
  };
  parallel_for(exec, x.size(), move_vertex, kGrain);
  return x;
}

/// Area of a triangle, twice as large.
struct TriangleArea {
  Vec3 vector;    // [m²]
  Real skin = 0;  // its size; 0 for triangles that have no area in the CT [m²]
};

/// Areas of all triangles. Triangles opened by a cut have no area in the CT.
std::vector<TriangleArea> triangle_areas(const Exec& exec, const BodySurface& surface,
                                         const SurfacePlan& plan, const std::vector<Vec3>& x) {
  const auto skin = std::size_t(surface.skin_triangles);
  TURGOR_CHECK(plan.rest_area.size() == skin && skin <= surface.triangles.size(), "the skin is listed first");
  std::vector<TriangleArea> areas(surface.triangles.size());
  const auto find = [&](std::size_t n) {
    const Int3 t = surface.triangles[n];
    const Vec3 a = x[std::size_t(t.x)];
    areas[n].vector = cross(x[std::size_t(t.y)] - a, x[std::size_t(t.z)] - a);
    areas[n].skin = n < skin && plan.rest_area[n] > 0 ? norm(areas[n].vector) : 0;
  };
  parallel_for(exec, areas.size(), find, kGrain);
  return areas;
}

/// Normals of the displaced vertices.
struct SurfaceNormals {
  const BodySurface& surface;
  const SurfacePlan& plan;
  Real step;                       // smallest spacing [m]
  std::vector<Vec3> area_vectors;  // sums around each vertex, twice the area [m²]

  /// Sum of the area vectors around a vertex. Slivers next to a lip may be inverted by rounding. A vertex
  /// with hardly any other triangles adds the sums of its neighbors.
  Vec3 area_around(std::size_t v) const {
    const Real sliver = Real(0.04) * step * step;
    Vec3 sum = area_vectors[v];
    if (!(norm(sum) < sliver)) return sum;
    for (const int at : plan.triangles_of(v)) {
      const Int3 t = surface.triangles[std::size_t(at / 3)];
      sum += area_vectors[std::size_t(t[(at + 1) % 3])] + area_vectors[std::size_t(t[(at + 2) % 3])];
    }
    return sum;
  }
  /// Area-weighted normal. The two lips of an almost closed cut share theirs, so that the cut is invisible.
  Vec3 at(std::size_t v, const std::vector<Vec3>& x) const {
    Vec3 normal = area_around(v);
    if (surface.twin[v] >= 0) {
      const auto twin = std::size_t(surface.twin[v]);
      normal += area_around(twin) * std::max(Real(0), 1 - norm(x[twin] - x[v]) / step);
    }
    return normalized(normal);
  }
};

/// Sums the areas around each vertex. `scalars` gets the area ratio A / A_CT − 1 of the skin around the
/// vertices if it is shown.
void sum_areas(const Exec& exec, const std::vector<TriangleArea>& areas, Shown shown, SurfaceNormals& out,
               std::vector<float>& scalars) {
  const SurfacePlan& plan = out.plan;
  out.area_vectors.resize(out.surface.rest.size());
  const auto sum = [&](std::size_t v) {
    Vec3 all;
    float skin = 0;
    for (const int at : plan.triangles_of(v)) {
      const TriangleArea& area = areas[std::size_t(at / 3)];
      all += area.vector, skin += area.skin;
    }
    out.area_vectors[v] = all;
    if (shown == Shown::kStretch) scalars[v] = plan.rest_around[v] > 0 ? skin / plan.rest_around[v] - 1 : 0;
  };
  parallel_for(exec, out.area_vectors.size(), sum, kGrain);
}

}  // namespace

std::vector<int> support_nodes(const Model& model, const Cuts& cuts,
                               std::span<const VirtualNodeDisplacement> virtual_u,
                               const BodySurface& surface) {
  const std::shared_ptr<const SurfacePlan> plan = plan_of(Exec(1), model, cuts, surface);
  std::vector<int> nodes;
  for (const int corner : plan->corners)
    add_support_nodes(model, cuts, virtual_u, *surface.fragments, corner, nodes);
  sort_unique(nodes);
  return nodes;
}

void deform_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown,
                    const Exec& exec, TriMesh& mesh) {
  // displaced vertices
  const std::shared_ptr<const SurfacePlan> plan = plan_of(exec, model, state.cuts, surface);
  const std::size_t count = surface.rest.size();
  mesh.vertices.resize(count), mesh.normals.resize(count);
  mesh.scalars.resize(shown == Shown::kNothing ? 0 : count);
  std::vector<Vec3> x = displace(exec, model, state, surface, *plan, shown, mesh.scalars);
  const Real step = std::min(
      {model.anatomy.lattice.spacing.x, model.anatomy.lattice.spacing.y, model.anatomy.lattice.spacing.z});
  detail::close_ends(surface, plan->ends, step, x);
  detail::close_fronts(plan->fronts, x);

  // areas of the triangles, summed around the vertices
  TURGOR_CHECK(surface.twin.size() == count && step > 0, "every vertex has a twin or a mark");
  SurfaceNormals normals{surface, *plan, step, {}};
  sum_areas(exec, triangle_areas(exec, surface, *plan, x), shown, normals, mesh.scalars);

  // to the patient frame
  const Vec3d origin = model.anatomy.grid.origin;
  const Mat3d& axes = model.anatomy.grid.axes;
  const auto to_patient = [&](std::size_t v) {
    mesh.vertices[v] = Vec3(origin + axes * Vec3d(x[v]));
    mesh.normals[v] = Vec3(axes * Vec3d(normals.at(v, x)));
  };
  parallel_for(exec, count, to_patient, kGrain);
  mesh.triangles = surface.triangles;
  if (determinant(axes) < 0)  // mirrored axes reverse the orientation
    for (Int3& t : mesh.triangles) std::swap(t.y, t.z);
}

TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown,
                         const Exec& exec) {
  TriMesh mesh;
  deform_surface(model, state, surface, shown, exec, mesh);
  return mesh;
}

}  // namespace turgor::lattice
