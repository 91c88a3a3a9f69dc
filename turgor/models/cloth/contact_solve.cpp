// Contacts are solved all at once (Jacobi): each vertex is split into as many equal masses as it has
// contacts, so that their corrections add up without overshooting [mass splitting: Tonge et al. 2012], and
// impulses are kept from step to step, so that a stack at rest needs no iterations at all.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 256;
constexpr double kCarriedThicknesses = 4;

/// The largest of many positive numbers, whatever their order.
struct Largest {
  std::atomic<std::uint32_t> bits{0};

  void take(Real a) {
    const std::uint32_t b = std::bit_cast<std::uint32_t>(a);
    std::uint32_t seen = bits.load(std::memory_order_relaxed);
    while (seen < b && !bits.compare_exchange_weak(seen, b)) {
    }
  }
  Real value() const { return std::bit_cast<Real>(bits.load()); }
};

Vec3 weighted_sum(const Contact& c, const Vectors& field) {
  Vec3 sum;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) sum += field[std::size_t(c.vertex[k])] * c.weight[k];
  return sum;
}

/// Finds the change of the impulse that stops the approach, and friction within Coulomb's cone; `beyond` of
/// the way that the iteration went is added to it.
void update_impulse(Contact& c, const Vectors& v, Real dt, Real beyond, Largest& largest) {
  const Vec3 u = weighted_sum(c, v) - c.drift;
  const Real un = dot(u, c.normal), too_fast = un + std::max(c.room, Real(0)) / dt;
  const Real impulse = std::max(Real(0), c.impulse - too_fast * c.mass);
  Vec3 rub = c.rub - (u - c.normal * un) * c.mass;
  rub -= c.normal * dot(rub, c.normal);
  const Real size = norm(rub), limit = c.friction * impulse;
  if (size > limit) rub *= limit / size;
  const Vec3 before = c.normal * c.impulse + c.rub, allowed = c.normal * impulse + rub;
  const Vec3 next = allowed + (allowed - c.allowed) * beyond;
  if (c.mass > 0) largest.take(norm(allowed - before) / c.mass);
  c.allowed = allowed, c.kick = next - before;
  c.impulse = dot(next, c.normal), c.rub = next - c.normal * c.impulse;
}

/// How far the weighted sum must move to have room.
void update_place(Contact& c, const Vectors& x, Real dt, Real beyond, Largest& largest) {
  Vec3 at = weighted_sum(c, x), normal = c.normal;
  Real distance = dot(at, normal);
  if (c.obstacle < 0 && c.vertex[2] < 0 && distance > 0) {  // two vertices: the direction follows them
    distance = norm(at);
    normal = at / distance;
  }
  const Real lack = c.plane + dt * dot(c.drift, c.normal) - distance;
  const Real allowed = std::max(Real(0), c.push + lack * c.mass);
  const Real next = allowed + beyond * (allowed - c.push_allowed);
  c.kick = normal * (next - c.push);
  c.push = next, c.push_allowed = allowed;
  if (lack > 0 && c.mass > 0) largest.take(lack);
}

/// With each vertex split among its contacts. Beside held vertices, one that has little weight could not be
/// asked to make up for all: weights count once there, not squared.
Real contact_mass(const Contact& c, const std::vector<int>& begin, const aligned_vector<Real>& free_mass) {
  bool is_held = false;
  for (const int v : c.vertex) is_held = is_held || (v >= 0 && free_mass[std::size_t(v)] == 0);
  Real sum = 0;
  for (std::size_t k = 0; k < 4; k++) {
    if (c.vertex[k] < 0) continue;
    const auto v = std::size_t(c.vertex[k]);
    const Real w = std::abs(c.weight[k]), share = Real(begin[v + 1] - begin[v]) * (is_held ? w : w * w);
    if (free_mass[v] > 0) sum += share / free_mass[v];
  }
  return sum > 0 ? 1 / sum : 0;
}

/// What the next step begins with: an impulse that moves its vertices by more than a few thicknesses belongs
/// to a state that holds make impossible, and would grow from step to step.
void set_carry(Contact& c, const aligned_vector<Real>& free_mass, Real largest_change) {
  Real mass = 0;
  for (const int v : c.vertex)
    if (v >= 0) mass += free_mass[std::size_t(v)];
  const Real limit = mass * largest_change;
  c.carry = c.impulse > limit && !c.is_borne ? limit / c.impulse : 1;
}

/// Gives every vertex its share of the kicks.
struct Kick {
  const Contacts& contacts;
  const aligned_vector<Real>& free_mass;
  Vectors& field;

  void operator()(std::size_t n) const {
    const auto vertex = std::size_t(contacts.touched[n]);
    if (free_mass[vertex] == 0) return;
    Vec3 sum;
    for (int m = contacts.begin[vertex]; m < contacts.begin[vertex + 1]; m++) {
      const auto item = std::size_t(contacts.item[std::size_t(m)]);
      const Contact& c = contacts.list[item / 4];
      sum += c.kick * c.weight[item % 4];
    }
    field.add(vertex, sum / free_mass[vertex]);
  }
};

/// Solved with the sheet, as all that touches its vertices: it has its impulse already.
bool is_settled(const Contacts& contacts, const Contact& c) {
  if (!c.is_borne) return false;
  for (const int v : c.vertex) {
    if (v < 0) continue;
    for (int n = contacts.begin[std::size_t(v)]; n < contacts.begin[std::size_t(v) + 1]; n++)
      if (!contacts.list[std::size_t(contacts.item[std::size_t(n)]) / 4].is_borne) return false;
  }
  return true;
}

/// The contacts whose velocities are looked at here.
std::vector<std::size_t> unsettled(const Contacts& contacts) {
  std::vector<std::size_t> list;
  for (std::size_t c = 0; c < contacts.list.size(); c++)
    if (!is_settled(contacts, contacts.list[c])) list.push_back(c);
  return list;
}

}  // namespace

void link_contacts(const Model& model, const State& state, Contacts& contacts) {
  auto& list = contacts.list;
  auto &begin = contacts.begin, &item = contacts.item, &touched = contacts.touched;
  touched.clear(), begin.clear();
  if (list.empty()) return;
  begin.assign(std::size_t(model.count) + 2, 0);
  std::size_t uses = 0;
  for (const Contact& c : list)
    for (const int v : c.vertex)
      if (v >= 0) begin[std::size_t(v) + 2]++, uses++;
  for (std::size_t i = 2; i < begin.size(); i++) {
    if (begin[i] > 0) touched.push_back(int(i) - 2);
    begin[i] += begin[i - 1];
  }
  item.resize(uses);
  for (std::size_t c = 0; c < list.size(); c++)
    for (std::size_t k = 0; k < 4; k++)
      if (const int v = list[c].vertex[k]; v >= 0)
        item[std::size_t(begin[std::size_t(v) + 1]++)] = int(4 * c + k);
  begin.pop_back();
  for (Contact& c : list) c.mass = contact_mass(c, begin, state.free_mass);
}

int solve_velocities(const Exec& exec, const Model& model, State& state, double dt) {
  Contacts& contacts = state.contacts;
  const Collision& params = model.params.collision;
  const Real small = Real(0.002 * params.thickness / dt);
  if (contacts.list.empty()) return 0;
  bool was_near = false;
  for (Contact& c : contacts.list) c.allowed = c.normal * c.impulse + c.rub, c.kick = {};
  const std::vector<std::size_t> open = unsettled(contacts);
  for (int iteration = 1; iteration <= params.iterations; iteration++) {
    Largest largest;
    const bool is_last = iteration == params.iterations || was_near;
    const Real beyond = is_last ? 0 : Real(iteration - 1) / Real(iteration + 2);
    parallel_for(
        exec, open.size(),
        [&](std::size_t n) { update_impulse(contacts.list[open[n]], state.v, Real(dt), beyond, largest); },
        kGrain);
    parallel_for(exec, contacts.touched.size(), Kick{contacts, state.free_mass, state.v}, kGrain);
    was_near = largest.value() < small;
    if (is_last) {
      for (Contact& c : contacts.list)
        set_carry(c, state.free_mass, Real(kCarriedThicknesses * params.thickness / dt));
      return iteration;
    }
  }
  return 0;
}

void solve_places(const Exec& exec, const Model& model, State& state, double dt) {
  Contacts& contacts = state.contacts;
  const Collision& params = model.params.collision;
  if (contacts.list.empty()) return;
  bool was_near = false;
  for (int iteration = 1; iteration <= params.iterations && !was_near; iteration++) {
    Largest largest;
    const Real beyond = iteration == params.iterations ? 0 : Real(iteration - 1) / Real(iteration + 2);
    parallel_for(
        exec, contacts.list.size(),
        [&](std::size_t c) { update_place(contacts.list[c], state.x, Real(dt), beyond, largest); }, kGrain);
    parallel_for(exec, contacts.touched.size(), Kick{contacts, state.free_mass, state.x}, kGrain);
    was_near = largest.value() < Real(0.002 * params.thickness);
  }
}

Vec3d place_of(const State& state, const Contact& c) {
  Vec3d place;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) place += Vec3d(state.x[std::size_t(c.vertex[k])]) * double(c.weight[k]);
  return place;
}

ObstacleLoad obstacle_load(const State& state, int obstacle, Vec3d centre) {
  ObstacleLoad load;
  for (const Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle) continue;
    const Vec3d impulse = impulse_on_obstacle(c);
    load.impulse += impulse;
    load.moment += cross(place_of(state, c) - centre, impulse);
  }
  return load;
}

}  // namespace turgor::cloth
