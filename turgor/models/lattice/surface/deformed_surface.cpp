// Deformation of the drawn surface: every vertex is embedded in its fragment.
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
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

/// End of a drawn cut, where no other cut meets it.
struct CutEnd {
  Vec3 position, back;      // at rest, lattice frame [m]; unit, along the skin from the end into the cut
  int left = 0, right = 0;  // vertices of the last lip
};

/// Lip of one incision at an end of it, and the lip that lies a step further inside.
std::optional<CutEnd> cut_end(const BodySurface& surface, int incision, bool at_begin, Real step) {
  const auto position = [&](const Lip* lip) { return surface.rest[std::size_t(lip->left)]; };
  const Real sign = at_begin ? Real(1) : Real(-1);
  const Lip *end = nullptr, *inner = nullptr;
  for (const Lip& lip : surface.lips)
    if (lip.incision == incision && (!end || sign * lip.along < sign * end->along)) end = &lip;
  if (!end) return {};
  for (const Lip& lip : surface.lips)
    if (lip.incision == incision && sign * (lip.along - end->along) > step &&
        (!inner || sign * lip.along < sign * inner->along))
      inner = &lip;
  if (!inner) return {};
  for (const Lip& lip : surface.lips)
    if (lip.incision != incision && norm(position(&lip) - position(end)) < 2 * step) return {};
  const Vec3 back = position(inner) - position(end);
  if (!(norm(back) > 0)) return {};
  return CutEnd{position(end), normalized(back), end->left, end->right};
}

/// Groups of at least two vertices that coincide at rest.
std::vector<std::vector<std::size_t>> coincident(const BodySurface& surface, Real tolerance,
                                                 std::vector<std::size_t> vertices) {
  const auto rest = [&](std::size_t v) { return surface.rest[v]; };
  std::sort(vertices.begin(), vertices.end(), [&](std::size_t a, std::size_t b) {
    return rest(a).x != rest(b).x ? rest(a).x < rest(b).x : a < b;
  });
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::uint8_t> is_done(vertices.size());
  for (std::size_t a = 0; a < vertices.size(); a++) {
    if (is_done[a]) continue;
    std::vector<std::size_t> group{vertices[a]};
    const Vec3 first = rest(vertices[a]);
    for (std::size_t b = a + 1; b < vertices.size() && rest(vertices[b]).x - first.x < tolerance; b++)
      if (!is_done[b] && norm(rest(vertices[b]) - first) < tolerance)
        is_done[b] = 1, group.push_back(vertices[b]);
    if (group.size() > 1) groups.push_back(std::move(group));
  }
  return groups;
}

/// Mean of the sides of a cut, where some vertices coincided at rest. A side may have several of them.
Vec3 middle_of_sides(const std::vector<std::size_t>& group, const std::vector<Vec3>& x) {
  Real widest = 0;
  for (const std::size_t a : group)
    for (const std::size_t b : group) widest = std::max(widest, norm(x[a] - x[b]));
  if (!(widest > 0)) return x[group.front()];
  // each vertex counts by the share that it has of its side
  Vec3 sum;
  Real total = 0;
  for (const std::size_t a : group) {
    Real same_side = 0;
    for (const std::size_t b : group) same_side += std::max(Real(0), 1 - 4 * norm(x[a] - x[b]) / widest);
    sum += x[a] / same_side, total += 1 / same_side;
  }
  return sum / total;
}

struct MovedVertex {
  std::size_t vertex;
  Vec3 before, shift;  // position before, and its move [m]
};

/// Moves the vertices beside moved ones with the nearest of their side, and less with their distance. A
/// vertex of a lip may have none on the other side that coincided with it, and would be a tooth at the end of
/// the cut.
void move_beside(const BodySurface& surface, Real step, const std::vector<std::size_t>& near,
                 const std::vector<MovedVertex>& moved, std::vector<Vec3>& x) {
  constexpr Real kReach = 0.5;  // [steps]
  std::vector<std::size_t> done;
  for (const MovedVertex& m : moved) done.push_back(m.vertex);
  std::sort(done.begin(), done.end());
  for (const std::size_t v : near) {
    if (std::binary_search(done.begin(), done.end(), v)) continue;
    // nearest at rest and by displacement, which differs between both sides
    Real least = kReach * step;
    Vec3 shift;
    for (const MovedVertex& m : moved) {
      const Vec3 away = surface.rest[v] - surface.rest[m.vertex];
      const Real distance = norm(away) + norm(x[v] - m.before - away);
      if (distance < least) least = distance, shift = m.shift;
    }
    x[v] += shift * (1 - least / (kReach * step));
  }
}

/// Moves vertices that coincided at rest to the middle of their sides at the end of a cut, and less up to
/// kClosing steps inside it, so that the lips meet in a point: cells open as a whole, and would end in an
/// edge. The opening is multiplied by t (2 − t), with t from 0 at the end to 1 inside, which has no kink
/// there. Ends that gape wider than kWidest steps, and ends at which a cut leaves the body, stay open. On
/// fine lattices the cell at the end of a wide wound gapes by more than its own size.
void close_end(const BodySurface& surface, const CutEnd& end, Real step, std::vector<Vec3>& x) {
  constexpr Real kClosing = 2.5, kWidest = 4;  // [steps]
  const Real gape = norm(x[std::size_t(end.left)] - x[std::size_t(end.right)]) / step;
  const Real strength = std::min(Real(1), kWidest - gape);
  if (!(strength > 0)) return;
  // vertices near the end
  std::vector<std::size_t> near;
  bool has_tissue_beyond = false;
  for (std::size_t v = 0; v < x.size(); v++) {
    const Vec3 away = surface.rest[v] - end.position;
    if (norm(away) > (kClosing + Real(0.5)) * step) continue;
    const Real inside = dot(away, end.back);
    const bool is_cut = surface.embedding[v].fragment >= 0;
    has_tissue_beyond |= !is_cut && inside < -step / 4;
    if (is_cut && inside < kClosing * step && inside > -step) near.push_back(v);
  }
  if (!has_tissue_beyond) return;
  // both sides of the cut
  std::vector<MovedVertex> moved;
  for (const std::vector<std::size_t>& group : coincident(surface, Real(1e-3) * step, near)) {
    const Vec3 middle = middle_of_sides(group, x);
    const Vec3 away = surface.rest[group.front()] - end.position;
    const Real t = std::max(Real(0), dot(away, end.back) / (kClosing * step));
    const Real opening = 1 - strength * (1 - t * (2 - t));
    for (const std::size_t v : group) moved.push_back({v, x[v], (middle - x[v]) * (1 - opening)});
  }
  for (const MovedVertex& m : moved) x[m.vertex] += m.shift;
  move_beside(surface, step, near, moved, x);
}

/// Closes both ends of every cut.
void close_ends(const BodySurface& surface, Real step, std::vector<Vec3>& x) {
  std::vector<int> incisions;
  for (const Lip& lip : surface.lips) incisions.push_back(lip.incision);
  sort_unique(incisions);
  for (const int incision : incisions)
    for (const bool at_begin : {true, false})
      if (const std::optional<CutEnd> end = cut_end(surface, incision, at_begin, step))
        close_end(surface, *end, step, x);
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
  close_ends(surface, step, x);

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
