// Tied points of attachments, and distances at rest of contacts.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/sim/organs/cloth_attachments.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Some surface vertices of a body with the area around each.
struct SurfaceVertices {
  std::vector<int> vertex;   // ascending
  std::vector<double> area;  // of each [m²]
};

/// Rest surface of a body in attachments and contacts.
struct CoupledSurface {
  int index = 0;  // see coupled_index
  std::string name;
  std::span<const Vec3d> vertices;  // of the whole mesh [m]
  std::span<const Int3> triangles;
  const RigidBody* rigid = nullptr;
  bool is_support = false;
};

CoupledSurface coupled_surface(const World& world, BodyId id) {
  const int index = coupled_index(world, id);
  if (id.kind == BodyKind::kRigid) {
    const RigidBody& body = world.rigid_bodies[std::size_t(id.index)];
    return {index, body.name, body.model.vertices, body.model.triangles, &body};
  }
  if (id.kind != BodyKind::kSfem) {
    const CoupledSupport& support = world.coupling.supports[std::size_t(index - first_support(world))];
    return {index, touched_body(world, id).name, support.rest, support.triangles, nullptr, true};
  }
  const SfemBody& body = world.sfem_bodies[std::size_t(id.index)];
  return {index, body.name, body.model.body.mesh.vertices, body.model.surface.triangles, nullptr};
}

/// All vertices of a surface, ascending.
std::vector<int> surface_vertices(const CoupledSurface& surface) {
  std::vector<int> vertices;
  for (const Int3 t : surface.triangles) vertices.insert(vertices.end(), {t.x, t.y, t.z});
  sort_unique(vertices);
  return vertices;
}

/// Sets the area around each vertex: a third of the triangles between these vertices, or of all around them
/// if there is none.
void measure_areas(const CoupledSurface& surface, SurfaceVertices& of) {
  const std::span<const Vec3d> x = surface.vertices;
  std::vector<std::uint8_t> is_listed(x.size(), 0);
  for (const int v : of.vertex) is_listed[std::size_t(v)] = 1;
  for (const bool between : {true, false}) {
    std::vector<double> area(x.size(), 0.0);
    for (const Int3 t : surface.triangles) {
      const int listed =
          is_listed[std::size_t(t.x)] + is_listed[std::size_t(t.y)] + is_listed[std::size_t(t.z)];
      const Vec3d a = x[std::size_t(t.x)], b = x[std::size_t(t.y)], c = x[std::size_t(t.z)];
      if (!between || listed == 3)
        for (const int v : {t.x, t.y, t.z}) area[std::size_t(v)] += norm(cross(b - a, c - a)) / 6;
    }
    double sum = 0;
    of.area.clear();
    for (const int v : of.vertex) of.area.push_back(area[std::size_t(v)]), sum += of.area.back();
    if (sum > 0) return;
  }
}

/// Keeps `most` vertices that are far from each other; each takes the area of those nearest to it.
void thin_out(std::span<const Vec3d> x, std::size_t most, SurfaceVertices& of) {
  const std::size_t count = of.vertex.size();
  if (count <= most) return;
  const auto at = [&](std::size_t n) { return x[std::size_t(of.vertex[n])]; };
  // farthest point first, beginning with the first vertex
  std::vector<double> distance(count, HUGE_VAL);
  std::vector<std::size_t> owner(count, 0), kept;
  for (std::size_t next = 0; kept.size() < most;) {
    for (std::size_t n = 0; n < count; n++)
      if (const double d = norm(at(n) - at(next)); d < distance[n]) distance[n] = d, owner[n] = kept.size();
    kept.push_back(next);
    next = std::size_t(std::max_element(distance.begin(), distance.end()) - distance.begin());
  }
  // areas
  SurfaceVertices thin;
  for (const std::size_t n : kept) thin.vertex.push_back(of.vertex[n]), thin.area.push_back(0);
  for (std::size_t n = 0; n < count; n++) thin.area[owner[n]] += of.area[n];
  of = std::move(thin);
}

/// Error if a body cannot be coupled. The reader of scenes has checked solvers and devices.
Status check_body(const std::string& where, const World& world, BodyId id) {
  if (id.kind != BodyKind::kSfem) return Done{};
  const SfemBody& body = world.sfem_bodies[std::size_t(id.index)];
  if (!body.facts.on_demand) return Done{};
  return Error{
      fmt::format("{}: {} computes its Green's functions on demand, which cannot be coupled: raise "
                  "body.{}.memory, or use a coarser mesh",
                  where, body.name, body.name)};
}

/// Point of another body's surface, or of the ground, that each vertex is tied to.
struct Targets {
  SurfaceVertices from;
  std::vector<contact::SurfacePoint> to;
  double nearest = HUGE_VAL;  // distance between the surfaces in the box [m]
};

Targets find_targets(const AttachmentScene& scene, const CoupledSurface& body, const CoupledSurface* other) {
  Targets found;
  TriangleTree tree;
  if (other)
    tree = build_triangle_tree({other->vertices.begin(), other->vertices.end()},
                               {other->triangles.begin(), other->triangles.end()});
  for (const int v : surface_vertices(body)) {
    const Vec3d p = body.vertices[std::size_t(v)];
    if (scene.box && squared_distance(box_around(*scene.box), p) > 0) continue;
    contact::SurfacePoint to{.rest = p};
    if (other) {
      // nearest point of the other surface
      const TrianglePoint near = nearest_point(tree, p);
      found.nearest = std::min(found.nearest, near.distance);
      if (near.distance > scene.distance) continue;
      to = {other->index, tree.triangles[std::size_t(near.triangle)], near.weights, near.position};
    }
    found.from.vertex.push_back(v), found.to.push_back(to);
  }
  return found;
}

/// Removes vertices that no triangle between tied vertices contains.
void remove_without_area(Targets& found) {
  Targets kept;
  for (std::size_t n = 0; n < found.to.size(); n++) {
    if (!(found.from.area[n] > 0)) continue;
    kept.from.vertex.push_back(found.from.vertex[n]), kept.from.area.push_back(found.from.area[n]);
    kept.to.push_back(found.to[n]);
  }
  found.from = std::move(kept.from), found.to = std::move(kept.to);
}

Error nothing_tied(const AttachmentScene& scene, const Targets& found, const CoupledSurface& body) {
  if (std::isinf(found.nearest)) {
    const Box box = box_around(body.vertices);
    return {
        fmt::format("{}: the box contains no surface vertex of {}, which extends from {:.4g}, {:.4g}, "
                    "{:.4g} to {:.4g}, {:.4g}, {:.4g} m",
                    scene.source_location, body.name, box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                    box.high.z)};
  }
  return {
      fmt::format("{}: no point of {} is within {:.4g} m of the other body: the nearest is {:.4g} m "
                  "away; raise distance",
                  scene.source_location, body.name, scene.distance, found.nearest)};
}

/// Springs of an attachment share its stiffness and strength by area.
contact::Tie made_tie(const AttachmentScene& scene, const Attachment& whole, double share,
                      const contact::SurfacePoint& a, const contact::SurfacePoint& b) {
  return {.a = a,
          .b = b,
          .stiffness = whole.stiffness * share,
          .slack = scene.slack,
          .strength = scene.break_force * share,
          .force = {}};
}

Error too_far(const AttachmentScene& scene, Vec3d point, const CoupledSurface& other, double distance) {
  return {fmt::format(
      "{}: the point {:.4g}, {:.4g}, {:.4g} m is {:.4g} m away from {}, expected at most {:.4g} m: "
      "raise distance to tie it to the nearest point of that surface",
      scene.source_location, point.x, point.y, point.z, distance, other.name, scene.distance)};
}

/// Points of a rigid body tied to the ground, to the same points of another rigid body, or to the nearest
/// ones of a surface that deforms.
Result<Attachment> attachment_at_points(const AttachmentScene& scene, const CoupledSurface& body,
                                        const CoupledSurface* other, Attachment made) {
  if (!(scene.stiffness > 0))
    return Error{scene.source_location +
                 ": points have no area, expected stiffness instead of "
                 "stiffness_per_area"};
  made.stiffness = scene.stiffness;
  TriangleTree tree;
  if (other && !other->rigid)
    tree = build_triangle_tree({other->vertices.begin(), other->vertices.end()},
                               {other->triangles.begin(), other->triangles.end()});
  for (const Vec3d p : scene.at) {
    const contact::SurfacePoint from{body.index, {-1, -1, -1}, {}, p};
    contact::SurfacePoint to{.body = other ? other->index : -1, .rest = p};
    if (other && !other->rigid) {
      const TrianglePoint near = nearest_point(tree, p);
      if (near.distance > scene.distance) return too_far(scene, p, *other, near.distance);
      to = {other->index, tree.triangles[std::size_t(near.triangle)], near.weights, near.position};
    }
    made.ties.push_back(made_tie(scene, made, 1.0 / double(scene.at.size()), from, to));
  }
  return made;
}

/// The points of a tie with a rigid body coincide at rest, so that the offset between them turns with the
/// body.
void join_rigid_points(bool is_a_rigid, bool is_b_rigid, std::vector<contact::Tie>& ties) {
  for (contact::Tie& tie : ties)
    if (is_a_rigid)
      tie.a.rest = tie.b.rest;
    else if (is_b_rigid)
      tie.b.rest = tie.a.rest;
}

Result<Attachment> load_attachment(const AttachmentScene& scene, const World& world) {
  // bodies; the surface points are those of the body that deforms
  if (const Status able = check_body(scene.source_location, world, scene.body); !able) return able.error();
  if (scene.other)
    if (const Status able = check_body(scene.source_location, world, *scene.other); !able)
      return able.error();
  CoupledSurface body = coupled_surface(world, scene.body);
  std::optional<CoupledSurface> other;
  if (scene.other) other = coupled_surface(world, *scene.other);
  Attachment made{.name = scene.name, .between = {body.name, other ? other->name : "ground"}, .ties = {}};
  if (!scene.at.empty()) {
    Result<Attachment> at_points =
        attachment_at_points(scene, body, other ? &*other : nullptr, std::move(made));
    if (at_points) join_rigid_points(other.has_value(), false, at_points->ties);
    return at_points;
  }
  made.swept = swept_side(world, scene.body, scene.other);
  const bool is_swapped = (body.rigid && other && !other->rigid) || made.swept == 1;
  const bool is_cloth =
      scene.body.kind == BodyKind::kCloth || (scene.other && scene.other->kind == BodyKind::kCloth);
  if (is_swapped) std::swap(body, *other);

  // tied points
  Targets found = find_targets(scene, body, other ? &*other : nullptr);
  if (found.from.vertex.empty() && scene.is_optional) return Attachment{};
  if (found.from.vertex.empty()) return nothing_tied(scene, found, body);
  measure_areas(body, found.from);
  remove_without_area(found);
  const SurfaceVertices all = found.from;
  thin_out(body.vertices, std::size_t(scene.points), found.from);

  // springs
  for (const double area : found.from.area) made.area += area;
  made.stiffness = scene.stiffness > 0 ? scene.stiffness : scene.stiffness_per_area * made.area;
  for (std::size_t n = 0; n < found.from.vertex.size(); n++) {
    const int v = found.from.vertex[n];
    const auto at = std::lower_bound(all.vertex.begin(), all.vertex.end(), v) - all.vertex.begin();
    const double share = found.from.area[n] / made.area;
    const contact::SurfacePoint from{body.index, {v, -1, -1}, {1, 0, 0}, body.vertices[std::size_t(v)]};
    made.ties.push_back(made_tie(scene, made, share, from, found.to[std::size_t(at)]));
  }
  if (!is_cloth) join_rigid_points(body.rigid && other, other && other->rigid, made.ties);
  if (is_swapped)
    for (contact::Tie& tie : made.ties) std::swap(tie.a, tie.b);
  if (is_cloth)
    if (const Status able = check_cloth_attachment(world, scene.source_location, made); !able)
      return able.error();
  return made;
}

contact::PairSurface rest_pair_surface(const CoupledSurface& surface) {
  return {surface.index, surface.vertices, surface.vertices, surface.triangles, {}};
}

/// Smallest extent of the box around a surface [m].
double smallest_extent(const CoupledSurface& surface) {
  const Box box = box_around(surface.vertices);
  const Vec3d size = box.high - box.low;
  return std::min({size.x, size.y, size.z});
}

/// Distances within which sites are found, before the motion of a frame is added.
void set_reach(const CoupledSurface& body, const CoupledSurface* other, contact::PairParams& params) {
  constexpr double kReach = 0.25, kDeepest = 2;              // of an edge
  constexpr double kRigidReach = 0.05, kRigidDeepest = 0.5;  // of the extent of rigid bodies
  double edge = 0, extent = HUGE_VAL;
  for (const CoupledSurface* surface : {&body, other}) {
    if (!surface) continue;
    if (surface->rigid)
      extent = std::min(extent, smallest_extent(*surface));
    else
      edge = std::max(edge, contact::mean_edge(surface->vertices, surface->triangles));
  }
  params.reach = params.gap + (edge > 0 ? kReach * edge : kRigidReach * extent);
  params.deepest = edge > 0 ? kDeepest * edge : kRigidDeepest * extent;
}

/// Adds the nodes of the swept side, and their distances at rest from a body that deforms.
BodyContact swept_contact(const Exec& exec, World& world, BodyContact made) {
  const int index = made.body[std::size_t(made.swept)], other = made.body[std::size_t(1 - made.swept)];
  CoupledSupport& support = world.coupling.supports[std::size_t(index - first_support(world))];
  const LatticeBody& body = world.lattice_bodies[std::size_t(support.body.index)];
  if (support.nodes.slot.empty()) support.nodes = swept_nodes(body, support);
  if (other >= first_support(world))
    made.rest_height[std::size_t(made.swept)] = swept_rest_heights(exec, world, made);
  return made;
}

Result<BodyContact> load_contact(const Exec& exec, const BodyContactScene& scene, World& world) {
  if (const Status able = check_body(scene.source_location, world, scene.body); !able) return able.error();
  if (scene.other)
    if (const Status able = check_body(scene.source_location, world, *scene.other); !able)
      return able.error();
  const CoupledSurface body = coupled_surface(world, scene.body);
  std::optional<CoupledSurface> other;
  if (scene.other) other = coupled_surface(world, *scene.other);
  BodyContact made{.name = scene.name,
                   .between = {body.name, other ? other->name : "ground"},
                   .body = {body.index, other ? other->index : -1},
                   .ground = {scene.through, normalized(scene.normal)}};
  // sites are found before they touch
  made.params = {.gap = scene.gap, .friction = scene.friction, .capacity = scene.sites};
  set_reach(body, other ? &*other : nullptr, made.params);
  made.swept = swept_side(world, scene.body, scene.other);
  if (made.swept >= 0) return swept_contact(exec, world, std::move(made));
  // deformable surfaces that are nearer than the gap at rest stay so
  if (!other || body.rigid || other->rigid) return made;
  const contact::PairSurface a = rest_pair_surface(body), b = rest_pair_surface(*other);
  made.rest_height[0] = contact::rest_heights(exec, a, b, made.params.reach, made.params.deepest);
  made.rest_height[1] = contact::rest_heights(exec, b, a, made.params.reach, made.params.deepest);
  return made;
}

/// True if the bodies are farther from each other at rest than they are likely to move.
bool are_apart(const BodyContactScene& scene, const World& world) {
  constexpr double kNear = 0.02;  // [m]
  if (!scene.other) return false;
  const Box boxes[] = {box_around(coupled_surface(world, scene.body).vertices),
                       box_around(coupled_surface(world, *scene.other).vertices)};
  const Vec3d margin{kNear, kNear, kNear};
  return !meet({boxes[0].low - margin, boxes[0].high + margin}, boxes[1]);
}

}  // namespace

Status load_coupling(const Exec& exec, const Scene& scene, World& world) {
  add_supports(exec, scene, world);
  for (const AttachmentScene& attachment : scene.attachments) {
    Result<Attachment> made = load_attachment(attachment, world);
    if (!made) return made.error();
    if (made->ties.empty()) continue;
    world.coupling.attachments.push_back(std::move(*made));
  }
  for (const BodyContactScene& contact : scene.body_contacts) {
    if (contact.is_optional && are_apart(contact, world)) continue;
    Result<BodyContact> made = load_contact(exec, contact, world);
    if (!made) return made.error();
    world.coupling.contacts.push_back(std::move(*made));
  }
  return Done{};
}

}  // namespace turgor
