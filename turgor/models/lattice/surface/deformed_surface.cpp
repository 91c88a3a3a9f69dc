// Deformation of the drawn surface: every vertex is embedded in its fragment.
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {

namespace {

constexpr std::size_t kGrain = 4096;  // vertices per task

/// Calls see(vertex, corner, weight) for the corners that the vertices [begin, end) are interpolated from.
template <class See>
void for_corners(const Model& model, const BodySurface& surface, std::size_t begin, std::size_t end,
                 const See& see) {
  const Vec3 h = model.anatomy.lattice.spacing;
  for (std::size_t v = begin; v < end; v++) {
    const EmbeddingCell& embedding = surface.embedding[v];
    const auto corners = corners_of(model, *surface.fragments, embedding.cell, embedding.fragment);
    const Vec3 at = surface.rest[v];
    const auto weight = trilinear(Vec3{at.x / h.x, at.y / h.y, at.z / h.z} -
                                  Vec3(slot_node(model.anatomy.lattice, embedding.cell)));
    for (std::size_t c = 0; c < 8; c++)
      if (weight[c] != 0) see(v, corners[c], weight[c]);
  }
}
/// Table of all corners, initialized to -1.
std::vector<int> corner_table(const Model& model, const BodySurface& surface) {
  return std::vector<int>(
      std::size_t(slot_count(model.anatomy.lattice)) + surface.fragments->virtual_nodes.size(), -1);
}

/// Displacement of every vertex, lattice frame [m]. Each thread evaluates each of its corners once.
std::vector<Vec3> displacements(const Exec& exec, const Model& model, const State& state,
                                const BodySurface& surface) {
  TURGOR_CHECK(surface.embedding.size() == surface.rest.size(), "every vertex is embedded in a cell");
  std::vector<Vec3> result(surface.rest.size());
  const auto grain = std::max(kGrain, result.size() / std::size_t(exec.threads()) + 1);
  exec.run_ranges(result.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<int> index_of_corner = corner_table(model, surface);
    std::vector<Vec3> corner_u;
    for_corners(model, surface, begin, end, [&](std::size_t v, int corner, Real weight) {
      int& index = index_of_corner[std::size_t(corner)];
      if (index < 0) {
        index = int(corner_u.size());
        corner_u.push_back(corner_displacement(model, state, *surface.fragments, corner));
      }
      result[v] += corner_u[std::size_t(index)] * weight;
    });
  });
  return result;
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

/// Moves vertices that coincided at rest to their mean at the end of a cut, and less up to kClosing steps
/// inside it, so that the lips meet in a point: cells open as a whole, and would end in an edge. The opening
/// is multiplied by t (2 − t), with t from 0 at the end to 1 inside, which has no kink there. Ends that gape
/// wider than two steps, and ends at which a cut leaves the body, stay open.
void close_end(const BodySurface& surface, const CutEnd& end, Real step, std::vector<Vec3>& x) {
  constexpr Real kClosing = 2.5;  // [steps]
  const Real gape = norm(x[std::size_t(end.left)] - x[std::size_t(end.right)]) / step;
  const Real strength = std::min(Real(1), 2 - gape);
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
  for (const std::vector<std::size_t>& group : coincident(surface, Real(1e-3) * step, std::move(near))) {
    Vec3 sum;
    for (const std::size_t v : group) sum += x[v];
    const Vec3 mean = sum / Real(group.size());
    const Vec3 away = surface.rest[group.front()] - end.position;
    const Real t = std::max(Real(0), dot(away, end.back) / (kClosing * step));
    const Real opening = 1 - strength * (1 - t * (2 - t));
    for (const std::size_t v : group) x[v] = mean + (x[v] - mean) * opening;
  }
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

Vec3 area_vector(const std::vector<Vec3>& x, Int3 t) {
  const Vec3 a = x[std::size_t(t.x)];
  return cross(x[std::size_t(t.y)] - a, x[std::size_t(t.z)] - a);
}

/// Area vectors of all triangles, twice their area [m²].
std::vector<Vec3> area_vectors(const Exec& exec, const BodySurface& surface, const std::vector<Vec3>& x) {
  std::vector<Vec3> areas(surface.triangles.size());
  parallel_for(
      exec, areas.size(), [&](std::size_t t) { areas[t] = area_vector(x, surface.triangles[t]); }, kGrain);
  return areas;
}

/// Sum of the area vectors around each vertex. Slivers next to a lip may be inverted by rounding. A vertex
/// with hardly any other triangles adds the sums of its neighbors.
std::vector<Vec3> area_around(const BodySurface& surface, const std::vector<Vec3>& areas, Real step) {
  const Real sliver = Real(0.04) * step * step;
  std::vector<Vec3> own(surface.rest.size());
  for (std::size_t t = 0; t < areas.size(); t++)
    for (int corner = 0; corner < 3; corner++) own[std::size_t(surface.triangles[t][corner])] += areas[t];
  std::vector<std::uint8_t> is_sliver(own.size());
  for (std::size_t v = 0; v < own.size(); v++) is_sliver[v] = norm(own[v]) < sliver;
  std::vector<Vec3> sums = own;
  for (const Int3 t : surface.triangles)
    for (int corner = 0; corner < 3; corner++)
      if (const auto v = std::size_t(t[corner]); is_sliver[v])
        sums[v] += own[std::size_t(t[(corner + 1) % 3])] + own[std::size_t(t[(corner + 2) % 3])];
  return sums;
}

/// Area-weighted vertex normals. The two lips of an almost closed cut share theirs, so that the cut is
/// invisible.
std::vector<Vec3> smooth_normals(const Exec& exec, const BodySurface& surface, const std::vector<Vec3>& x,
                                 const std::vector<Vec3>& areas, Real step) {
  TURGOR_CHECK(surface.twin.size() == x.size() && step > 0, "every vertex has a twin or a mark");
  const std::vector<Vec3> sums = area_around(surface, areas, step);
  std::vector<Vec3> normals = sums;
  const auto smooth = [&](std::size_t v) {
    if (surface.twin[v] >= 0) {
      const auto twin = std::size_t(surface.twin[v]);
      normals[v] += sums[twin] * std::max(Real(0), 1 - norm(x[twin] - x[v]) / step);
    }
    normals[v] = normalized(normals[v]);
  };
  parallel_for(exec, x.size(), smooth, kGrain);
  return normals;
}

/// Area ratio A / A_CT − 1 of the skin around each vertex. Triangles opened by a cut have no rest area and
/// are left out.
std::vector<float> stretches(const BodySurface& surface, const std::vector<Vec3>& areas, Real step) {
  TURGOR_CHECK(std::size_t(surface.skin_triangles) <= surface.triangles.size(), "the skin is listed first");
  // sum areas of the triangles around each vertex
  std::vector<float> now(surface.rest.size()), rest(surface.rest.size());
  for (int n = 0; n < surface.skin_triangles; n++) {
    const Int3 t = surface.triangles[std::size_t(n)];
    const float area_rest = norm(area_vector(surface.rest, t)), area_now = norm(areas[std::size_t(n)]);
    // skip degenerate triangles
    if (area_rest < 1e-5f * step * step) continue;
    for (int corner = 0; corner < 3; corner++) {
      rest[std::size_t(t[corner])] += area_rest;
      now[std::size_t(t[corner])] += area_now;
    }
  }
  // relative change of area
  for (std::size_t v = 0; v < now.size(); v++) now[v] = rest[v] > 0 ? now[v] / rest[v] - 1 : 0;
  return now;
}

}  // namespace

std::vector<int> support_nodes(const Model& model, const Cuts& cuts,
                               std::span<const VirtualNodeDisplacement> virtual_u,
                               const BodySurface& surface) {
  std::vector<int> index_of_corner = corner_table(model, surface), nodes;
  for_corners(model, surface, 0, surface.rest.size(), [&](std::size_t, int corner, Real) {
    if (int& seen = index_of_corner[std::size_t(corner)]; seen < 0) {
      seen = 1;
      add_support_nodes(model, cuts, virtual_u, *surface.fragments, corner, nodes);
    }
  });
  sort_unique(nodes);
  return nodes;
}

TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown,
                         const Exec& exec) {
  // displaced vertices
  const std::vector<Vec3> u = displacements(exec, model, state, surface);
  std::vector<Vec3> x(u.size());
  for (std::size_t v = 0; v < x.size(); v++) x[v] = surface.rest[v] + u[v];

  // normals and scalars
  const Real step = std::min(
      {model.anatomy.lattice.spacing.x, model.anatomy.lattice.spacing.y, model.anatomy.lattice.spacing.z});
  close_ends(surface, step, x);
  const std::vector<Vec3> areas = area_vectors(exec, surface, x);
  TriMesh mesh{.vertices = {},
               .triangles = surface.triangles,
               .normals = smooth_normals(exec, surface, x, areas, step),
               .scalars = {}};
  if (shown == Shown::kStretch) mesh.scalars = stretches(surface, areas, step);
  if (shown == Shown::kDisplacement)
    for (const Vec3 d : u) mesh.scalars.push_back(norm(d));

  // to the patient frame
  const Mat3d& axes = model.anatomy.grid.axes;
  mesh.vertices.resize(x.size());
  const auto to_patient = [&](std::size_t v) {
    mesh.vertices[v] = Vec3(model.anatomy.grid.origin + axes * Vec3d(x[v]));
    mesh.normals[v] = Vec3(axes * Vec3d(mesh.normals[v]));
  };
  parallel_for(exec, x.size(), to_patient, kGrain);
  if (determinant(axes) < 0)  // mirrored axes reverse the orientation
    for (Int3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

}  // namespace turgor::lattice
