#include "turgor/contact/viscosity.hpp"

#include <array>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::contact {

ViscousTick viscous_tick(const Viscosity& viscosity, double dt) {
  if (viscosity.stiffening <= 0) return {};
  TURGOR_CHECK(viscosity.time > 0 && dt >= 0, "a viscous material has a positive relaxation time");
  const double a = dt / viscosity.time;
  return {a, viscosity.stiffening / (1 + a)};
}

void remember(const ViscousTick& tick, std::span<const Vec3d> u, std::span<const Vec3d> f,
              ViscousHistory& history) {
  TURGOR_CHECK(u.size() == f.size() && history.v.size() == u.size() && history.phi.size() == u.size(),
               "every point has a displacement, a force and a viscous memory");
  const double a = tick.a, p = tick.p;
  for (std::size_t i = 0; i < u.size(); i++) {
    history.v[i] = (history.v[i] + a * u[i]) / (1 + a);
    history.phi[i] = (history.phi[i] + a / (1 + p) * (f[i] + p * history.phi[i])) / (1 + a);
  }
  history.far_fraction *= (1 + a * p / (1 + p)) / (1 + a);
}

std::vector<VertexForce> coarse_history(const ViscousHistory& history, const sfem::Patch& patch) {
  std::map<int, Vec3d> sum;
  for (const auto& [vertex, force] : history.far) sum[vertex] += history.far_fraction * force;
  // memory on the patch's points, restricted to coarse vertices
  std::vector<double> forces;
  for (const Vec3d f : history.phi) forces.insert(forces.end(), {f.x, f.y, f.z});
  const std::vector<double> coarse = sfem::coarse_forces(patch, forces);
  TURGOR_CHECK(coarse.size() == 3 * patch.coarse.size(), "three numbers a coarse vertex");
  for (std::size_t i = 0; i < patch.coarse.size(); i++)
    sum[patch.coarse[i]] += {coarse[3 * i], coarse[3 * i + 1], coarse[3 * i + 2]};
  // nonzero forces
  std::vector<VertexForce> out;
  for (const auto& [vertex, force] : sum)
    if (force != Vec3d{}) out.push_back({vertex, force});
  return out;
}

namespace {

/// Ξ between two vertices times a force. Zero for a vertex that is fixed or not stored.
Vec3d green_displacement(const sfem::Green& green, int vertex, const VertexForce& at) {
  TURGOR_CHECK(is_index(vertex, green.slot.size()) && is_index(at.vertex, green.slot.size()),
               "forces act on vertices of the body");
  const int row = green.slot[std::size_t(vertex)], column = green.slot[std::size_t(at.vertex)];
  if (row < 0 || column < 0 || !(sfem::has_column(green, row) || sfem::has_column(green, column))) return {};
  std::array<double, 9> b{};
  sfem::green_block(green, row, column, b);
  const Vec3d f = at.force;
  return {b[0] * f.x + b[3] * f.y + b[6] * f.z, b[1] * f.x + b[4] * f.y + b[7] * f.z,
          b[2] * f.x + b[5] * f.y + b[8] * f.z};
}

}  // namespace

std::vector<Vec3d> displacements(const sfem::Model& model, std::span<const VertexForce> forces,
                                 const sfem::Patch& patch) {
  // at coarse vertices
  std::vector<Vec3d> coarse;
  for (const int vertex : patch.coarse) {
    Vec3d sum;
    for (const VertexForce& force : forces) sum += green_displacement(model.green, vertex, force);
    coarse.push_back(sum);
  }
  // interpolated to the points of the patch
  std::vector<Vec3d> out;
  for (const sfem::PatchPoint& point : patch.points) {
    Vec3d sum;
    for (std::size_t i = 0; i < std::size_t(point.supports); i++)
      sum += point.weight[i] * coarse[std::size_t(point.coarse[i])];
    out.push_back(sum);
  }
  return out;
}

}  // namespace turgor::contact
