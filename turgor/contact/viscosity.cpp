#include "turgor/contact/viscosity.hpp"

#include <array>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::contact {

ViscousTick viscous_tick(const Prony& viscosity, double dt) {
  ViscousTick tick{.count = pair_count(viscosity)};
  for (std::size_t i = 0; i < std::size_t(tick.count); i++) {
    const PronyPair& pair = viscosity.pairs[i];
    TURGOR_CHECK(pair.time > 0 && dt >= 0, "a viscous material has a positive relaxation time");
    tick.a[i] = dt / pair.time;
    tick.p[i] = pair.ratio / (1 + tick.a[i]);
    tick.total += tick.p[i];
  }
  return tick;
}

Vec3d remembered_displacement(const ViscousTick& tick, const ViscousHistory& history, std::size_t point) {
  Vec3d sum;
  for (std::size_t i = 0; i < std::size_t(tick.count); i++)
    sum += tick.p[i] / (1 + tick.total) * history.pairs[i].v[point];
  return sum;
}

namespace {

/// Factors of far memory after a tick without force: φᵢ⁺ = (φᵢ + aᵢ Σ pⱼ' φⱼ/(1 + P))/(1 + aᵢ).
void decay_far(const ViscousTick& tick, ViscousHistory& history) {
  const auto before = history.far_factor;
  const auto count = std::size_t(tick.count);
  for (std::size_t i = 0; i < count; i++)
    for (std::size_t k = 0; k < std::size_t(kMostPronyPairs); k++) {
      double sum = 0;
      for (std::size_t j = 0; j < count; j++) {
        const double shared = tick.a[i] * tick.p[j] / (1 + tick.total), own = i == j ? 1 : 0;
        sum += (own + shared) / (1 + tick.a[i]) * before[j][k];
      }
      history.far_factor[i][k] = sum;
    }
}

}  // namespace

void remember(const ViscousTick& tick, std::span<const Vec3d> u, std::span<const Vec3d> f,
              ViscousHistory& history) {
  TURGOR_CHECK(u.size() == f.size() && history.count == tick.count,
               "every point has a displacement, a force and a viscous memory");
  const auto count = std::size_t(tick.count);
  for (std::size_t n = 0; n < u.size(); n++) {
    // force of the whole memory, before any pair changes
    Vec3d force = f[n];
    for (std::size_t i = 0; i < count; i++) force += tick.p[i] * history.pairs[i].phi[n];
    for (std::size_t i = 0; i < count; i++) {
      PairHistory& pair = history.pairs[i];
      const double a = tick.a[i];
      pair.v[n] = (pair.v[n] + a * u[n]) / (1 + a);
      pair.phi[n] = (pair.phi[n] + a / (1 + tick.total) * force) / (1 + a);
    }
  }
  decay_far(tick, history);
}

void change_pairs(const Prony& before, const Prony& after, std::span<const Vec3d> u, std::span<const Vec3d> f,
                  ViscousHistory& history) {
  TURGOR_CHECK(u.size() == f.size() && history.count == pair_count(before),
               "the memory belongs to the pairs");
  // the memory force of u: Ξ φ = u, by the identity u = (Ξ f + Σ pⱼ vⱼ)/(1 + P) after a tick
  const ViscousTick tick = viscous_tick(before, 0);
  const auto old = std::size_t(history.count), count = std::size_t(pair_count(after));
  for (std::size_t i = old; i < count; i++) {
    PairHistory& pair = history.pairs[i];
    pair.v.assign(u.begin(), u.end());
    pair.phi.assign(f.begin(), f.end());
    for (std::size_t n = 0; n < f.size(); n++) {
      for (std::size_t j = 0; j < old; j++) pair.phi[n] += tick.p[j] * history.pairs[j].phi[n];
      pair.phi[n] = pair.phi[n] / (1 + tick.total);
    }
    for (std::size_t k = 0; k < std::size_t(kMostPronyPairs); k++) {
      double sum = 0;
      for (std::size_t j = 0; j < old; j++) sum += tick.p[j] / (1 + tick.total) * history.far_factor[j][k];
      history.far_factor[i][k] = sum;
    }
  }
  history.count = int(count);
}

std::vector<VertexForce> coarse_history(const ViscousHistory& history, int pair, const sfem::Patch& patch) {
  TURGOR_CHECK(is_index(pair, std::size_t(history.count)), "the pair is in use");
  const auto own = std::size_t(pair);
  std::map<int, Vec3d> sum;
  for (std::size_t j = 0; j < std::size_t(kMostPronyPairs); j++)
    for (const auto& [vertex, force] : history.pairs[j].far)
      sum[vertex] += history.far_factor[own][j] * force;
  // memory on the patch's points, restricted to coarse vertices
  std::vector<double> forces;
  for (const Vec3d f : history.pairs[own].phi) forces.insert(forces.end(), {f.x, f.y, f.z});
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
