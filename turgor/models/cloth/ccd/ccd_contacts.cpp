// Contacts of pairs that collide in a step. The step is solved again with them, so that a layer that lands
// pushes those below it within the step [implicit contact handling: Otaduy et al. 2009].
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/large_primitive_kernels.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

/// Weights of the corners in the vector between the nearest points; their sum is 0.
std::array<double, 4> weights_between(const std::array<Vec3d, 4>& x, bool are_edges) {
  if (!are_edges) {
    const Vec3d w = nearest_on_triangle(x[0], x[1], x[2], x[3]).weights;
    return {1, -w.x, -w.y, -w.z};
  }
  // the nearest points x₀ + s p and x₂ + t q differ by a vector normal to p and q
  const Vec3d p = x[1] - x[0], q = x[3] - x[2], r = x[0] - x[2] - between_edges(x);
  const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), determinant = pp * qq - pq * pq;
  if (!(determinant > 1e-9 * pp * qq)) return {0.5, 0.5, -0.5, -0.5};
  const double s = std::clamp((pq * dot(q, r) - qq * dot(p, r)) / determinant, 0.0, 1.0),
               t = std::clamp((pp * dot(q, r) - pq * dot(p, r)) / determinant, 0.0, 1.0);
  return {1 - s, s, t - 1, -t};
}

}  // namespace

void find_collision_contacts(const Model& model, State& state, const Vectors& x,
                             std::vector<Contact>& found) {
  const CcdMotion motion = ccd_motion(view(model, state));
  const double thickness = model.params.collision.thickness;
  const LinearMotion linear{motion.start, motion.displacement, view(model.x_rest), thickness};
  for (const CcdPair& pair : state.ccd.ccd_pairs) {
    // primitives when they collide
    const LinearMotion::PrimitivePair primitives = linear.primitives(pair.vertex, pair.are_edges);
    double time = 0;
    comes_too_near(primitives.x, primitives.d, pair.are_edges, thickness, time);
    TURGOR_CHECK(time >= 0 && time <= 1, "the pair collides in the step");
    std::array<Vec3d, 4> y;
    for (std::size_t k = 0; k < 4; k++) y[k] = primitives.x[k] + primitives.d[k] * time;
    const Vec3d offset = between(y, pair.are_edges);
    const double distance = norm(offset);
    if (!(distance > 0)) continue;
    // weights, normal and gap
    const std::array<double, 4> weights = weights_between(y, pair.are_edges);
    Contact contact{.vertex = pair.vertex, .normal = Vec3(offset / distance)};
    Vec3d now, rest;
    for (std::size_t k = 0; k < 4; k++) {
      const auto v = std::size_t(pair.vertex[k]);
      contact.weight[k] = Real(weights[k]);
      now += Vec3d(x[v]) * weights[k], rest += Vec3d(model.x_rest[v]) * weights[k];
    }
    const Real least = least_distance(Real(norm(rest)), Real(thickness));
    if (least == 0) continue;
    const Real height = Real(dot(now, Vec3d(contact.normal)));
    contact.gap = height - least;
    contact.plane = std::min(least, std::max(height, Real(0)));
    contact.friction = Real(model.params.collision.friction);
    if (!is_implicit_already(state, contact, ContactPhase::kActual)) found.push_back(contact);
  }
}

}  // namespace turgor::cloth
