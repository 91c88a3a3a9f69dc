// Tied points of attachments, and distances at rest of contacts.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Some surface vertices of a body with the area around each.
struct SurfaceVertices {
  std::vector<int> vertex;   // ascending
  std::vector<double> area;  // of each [m²]
};

/// All vertices of a surface, ascending.
std::vector<int> surface_vertices(const sfem::Model& model) {
  std::vector<int> vertices;
  for (const Int3 t : model.surface.triangles) vertices.insert(vertices.end(), {t.x, t.y, t.z});
  sort_unique(vertices);
  return vertices;
}

/// Sets the area around each vertex: a third of the triangles between these vertices, or of all around them
/// if there is none.
void measure_areas(const sfem::Model& model, SurfaceVertices& of) {
  const std::vector<Vec3d>& x = model.body.mesh.vertices;
  std::vector<std::uint8_t> is_listed(x.size(), 0);
  for (const int v : of.vertex) is_listed[std::size_t(v)] = 1;
  for (const bool between : {true, false}) {
    std::vector<double> area(x.size(), 0.0);
    for (const Int3 t : model.surface.triangles) {
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
void thin_out(const std::vector<Vec3d>& x, std::size_t most, SurfaceVertices& of) {
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

/// Error if a body cannot be coupled.
Status check_body(const std::string& where, const SfemBody& body) {
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

Targets find_targets(const AttachmentScene& scene, const SfemBody& body, const SfemBody* other, int index) {
  Targets found;
  const std::vector<Vec3d>& x = body.model.body.mesh.vertices;
  TriangleTree tree;
  if (other) tree = build_triangle_tree(other->model.body.mesh.vertices, other->model.surface.triangles);
  for (const int v : surface_vertices(body.model)) {
    const Vec3d p = x[std::size_t(v)];
    if (scene.box && squared_distance(box_around(*scene.box), p) > 0) continue;
    contact::SurfacePoint to{.rest = p};
    if (other) {
      // nearest point of the other surface
      const TrianglePoint near = nearest_point(tree, p);
      found.nearest = std::min(found.nearest, near.distance);
      if (near.distance > scene.distance) continue;
      to = {index, tree.triangles[std::size_t(near.triangle)], near.weights, near.position};
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

Error nothing_tied(const AttachmentScene& scene, const Targets& found, const SfemBody& body) {
  if (std::isinf(found.nearest)) {
    const Box box = box_around(body.model.body.mesh.vertices);
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

Result<Attachment> load_attachment(const AttachmentScene& scene, const World& world) {
  // bodies
  const SfemBody& body = world.sfem_bodies[std::size_t(scene.body.index)];
  const SfemBody* other = scene.other ? &world.sfem_bodies[std::size_t(scene.other->index)] : nullptr;
  if (const Status able = check_body(scene.source_location, body); !able) return able.error();
  if (other)
    if (const Status able = check_body(scene.source_location, *other); !able) return able.error();

  // tied points
  Targets found = find_targets(scene, body, other, scene.other ? scene.other->index : -1);
  if (found.from.vertex.empty() && scene.is_optional) return Attachment{};
  if (found.from.vertex.empty()) return nothing_tied(scene, found, body);
  measure_areas(body.model, found.from);
  remove_without_area(found);
  const SurfaceVertices all = found.from;
  thin_out(body.model.body.mesh.vertices, std::size_t(scene.points), found.from);

  // springs
  Attachment made{.name = scene.name, .between = {body.name, other ? other->name : "ground"}, .ties = {}};
  for (const double area : found.from.area) made.area += area;
  made.stiffness = scene.stiffness > 0 ? scene.stiffness : scene.stiffness_per_area * made.area;
  for (std::size_t n = 0; n < found.from.vertex.size(); n++) {
    const int v = found.from.vertex[n];
    const auto at = std::lower_bound(all.vertex.begin(), all.vertex.end(), v) - all.vertex.begin();
    const double share = found.from.area[n] / made.area;
    made.ties.push_back(
        {.a = {scene.body.index, {v, -1, -1}, {1, 0, 0}, body.model.body.mesh.vertices[std::size_t(v)]},
         .b = found.to[std::size_t(at)],
         .stiffness = made.stiffness * share,
         .slack = scene.slack,
         .strength = scene.break_force * share,
         .force = {}});
  }
  return made;
}

contact::PairSurface rest_pair_surface(const World& world, int index) {
  const sfem::Model& model = world.sfem_bodies[std::size_t(index)].model;
  return {index, model.body.mesh.vertices, model.body.mesh.vertices, model.surface.triangles, {}};
}

Result<BodyContact> load_contact(const Exec& exec, const BodyContactScene& scene, const World& world) {
  constexpr double kReach = 0.25, kDeepest = 2;  // of an edge
  BodyContact made{.name = scene.name, .between = {}, .body = {scene.body.index, scene.other.index}};
  double edge = 0;
  for (int side = 0; side < 2; side++) {
    const SfemBody& body = world.sfem_bodies[std::size_t(made.body[std::size_t(side)])];
    if (const Status able = check_body(scene.source_location, body); !able) return able.error();
    made.between[std::size_t(side)] = body.name;
    edge = std::max(edge, contact::mean_edge(body.model.body.mesh.vertices, body.model.surface.triangles));
  }
  // sites are found before they touch
  made.params = {.gap = scene.gap,
                 .reach = scene.gap + kReach * edge,
                 .deepest = kDeepest * edge,
                 .friction = scene.friction,
                 .capacity = scene.sites};
  // surfaces that are nearer than the gap at rest stay so
  const contact::PairSurface a = rest_pair_surface(world, made.body[0]),
                             b = rest_pair_surface(world, made.body[1]);
  made.rest_height[0] = contact::rest_heights(exec, a, b, made.params.reach, made.params.deepest);
  made.rest_height[1] = contact::rest_heights(exec, b, a, made.params.reach, made.params.deepest);
  return made;
}

/// True if the bodies are farther from each other at rest than they are likely to move.
bool are_apart(const BodyContactScene& scene, const World& world) {
  constexpr double kNear = 0.02;  // [m]
  Box boxes[2];
  for (int side = 0; side < 2; side++)
    boxes[side] = box_around(world.sfem_bodies[std::size_t((side == 0 ? scene.body : scene.other).index)]
                                 .model.body.mesh.vertices);
  const Vec3d margin{kNear, kNear, kNear};
  return !meet({boxes[0].low - margin, boxes[0].high + margin}, boxes[1]);
}

}  // namespace

Status load_coupling(const Exec& exec, const Scene& scene, World& world) {
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
