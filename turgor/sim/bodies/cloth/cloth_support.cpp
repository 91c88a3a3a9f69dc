#include "turgor/sim/bodies/cloth/cloth_support.hpp"

#include <algorithm>

#include "turgor/core/sort_unique.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// The vertices that a body's triangles use; the triangles then count in them.
void use_vertices(const std::vector<Int3>& triangles, ClothSupport& support) {
  for (const Int3 t : triangles) support.carrier.insert(support.carrier.end(), {t.x, t.y, t.z});
  sort_unique(support.carrier);
  const auto place = [&](int v) {
    return int(std::lower_bound(support.carrier.begin(), support.carrier.end(), v) - support.carrier.begin());
  };
  for (const Int3 t : triangles) support.triangles.push_back({place(t.x), place(t.y), place(t.z)});
}

/// At rest plus a displacement of every vertex of the body.
std::vector<Vec3> displaced(const ClothSupport& support, const std::vector<Vec3d>& rest,
                            const std::vector<Vec3d>& displacement) {
  std::vector<Vec3> places;
  for (const int v : support.carrier)
    places.push_back(Vec3(rest[std::size_t(v)] + displacement[std::size_t(v)]));
  return places;
}

std::vector<Vec3> places_now(const Exec&, LatticeBody& body, ClothSupport& support) {
  keep_surface(body);
  support.carrier = body.surface.slot, support.triangles = body.surface.triangles;
  return lattice::deformed_surface(body.model, body.state, body.surface, lattice::Shown::kNothing).vertices;
}

std::vector<Vec3> places_now(const Exec& exec, SfemBody& body, ClothSupport& support) {
  if (support.carrier.empty()) use_vertices(body.model.surface.triangles, support);
  return displaced(support, body.model.body.mesh.vertices, coarse_displacements(exec, body));
}

std::vector<Vec3> places_now(const Exec&, RhombusBody& body, ClothSupport& support) {
  if (support.carrier.empty()) use_vertices(body.model.surface.triangles, support);
  return displaced(support, body.model.surface.vertices, body.state.displacement);
}

/// Bodies that tools can touch can be lain on.
std::vector<Vec3> places_now(const Exec& exec, ClothSupport& support, World& world) {
  return visit_body(world, support.body, [&](auto& body) -> std::vector<Vec3> {
    if constexpr (requires { places_now(exec, body, support); }) return places_now(exec, body, support);
    return {};
  });
}

}  // namespace

std::vector<lattice::NodeLoad> node_loads(const LatticeBody& body) {
  const Mat3d to_lattice = transposed(body.model.grid.axes);
  std::vector<lattice::NodeLoad> loads;
  for (const auto& [slot, f] : body.cloth.force) loads.push_back({slot, Vec3(to_lattice * f)});
  return loads;
}

void follow_body(const Exec& exec, ClothSupport& support, World& world) {
  std::vector<Vec3> now = places_now(exec, support, world);
  const bool comparable = support.places.size() == now.size();
  const TriMesh from{.vertices = comparable ? support.places : now, .triangles = support.triangles};
  support.moving = cloth::moving_surface(from, comparable ? now : std::vector<Vec3>(), world.dt);
  support.places = std::move(now);
}

void note_force(const cloth::State& state, int obstacle, double dt, ClothSupport& support) {
  std::vector<Vec3d> impulse(support.carrier.size());
  cloth::add_surface_impulses(state, obstacle, *support.moving, dt, impulse);
  support.force.clear();
  for (std::size_t v = 0; v < impulse.size(); v++)
    if (impulse[v] != Vec3d{}) support.force.push_back({support.carrier[v], impulse[v] / dt});
}

ClothPush push_on(const World& world, BodyId body) {
  ClothPush push;
  for (const ClothBody& cloth : world.cloth_bodies) {
    bool touches = false;
    for (const ClothObstacle& obstacle : cloth.obstacles) {
      if (!obstacle.support || obstacle.support->body != body) continue;
      const auto& force = obstacle.support->force;
      push.force.insert(push.force.end(), force.begin(), force.end());
      touches = touches || !force.empty();
    }
    if (touches) push.mass += cloth.model.total_mass;
  }
  return push;
}

/// A node that a change of the force accelerates moves by w f h² at most: its neighbours hold it back.
void press_body(const Exec&, LatticeBody& body, const ClothPush& push, double dt) {
  ClothLoad& load = body.cloth;
  take_over(push, load);
  double largest = 0;
  for (const auto& [slot, f] : load.force)
    largest = std::max(largest, norm(f) * double(body.model.inverse_mass[std::size_t(slot)]));
  const double sum = sum_of_sizes(load), answer = sum > 0 ? largest * dt * dt / sum : 0;
  load.answer = {answer, answer, answer};
  choose_part(push.mass, dt, load);
}

}  // namespace turgor
