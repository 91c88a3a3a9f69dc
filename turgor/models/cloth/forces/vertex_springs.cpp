#include "turgor/models/cloth/forces/vertex_springs.hpp"

#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

VertexSpringForce spring_force(const VertexSpring& spring, Vec3 x) {
  const Vec3 d = x - spring.target;
  const Real k = spring.stiffness;
  if (spring.slack == 0) return {.force = d * -k, .diagonal = {k, k, k}};
  const Real length = norm(d), over = length - spring.slack;
  if (!(over > 0)) return {.force = {}};
  // k along d, and k (1 − s/|d|) across it
  const Vec3 n = d / length;
  const Real across = k * over / length, along = k - across;
  return {.force = n * (-k * over),
          .diagonal = {across + along * n.x * n.x, across + along * n.y * n.y, across + along * n.z * n.z},
          .off = {along * n.x * n.y, along * n.x * n.z, along * n.y * n.z}};
}

void add_vertex_springs(std::span<const VertexSpring> springs, const State& state, double dt,
                        Vectors& impulse, Vectors& diagonal, Vectors& off) {
  const Real s = Real(dt * dt);
  for (const VertexSpring& spring : springs) {
    TURGOR_CHECK(is_index(spring.vertex, state.x.size()), "springs act on vertices of the cloth");
    const auto v = std::size_t(spring.vertex);
    const VertexSpringForce now = spring_force(spring, state.x[v]);
    impulse.add(v, now.force * Real(dt) - now.stiffness_times(state.v[v]) * s);
    diagonal.add(v, now.diagonal * s), off.add(v, now.off * s);
  }
}

void add_vertex_loads(std::span<const VertexLoad> loads, double dt, Vectors& impulse) {
  for (const VertexLoad& load : loads) {
    TURGOR_CHECK(is_index(load.vertex, impulse.size()), "loads act on vertices of the cloth");
    impulse.add(std::size_t(load.vertex), load.force * Real(dt));
  }
}

}  // namespace turgor::cloth
