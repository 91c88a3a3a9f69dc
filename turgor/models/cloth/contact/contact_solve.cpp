// Contacts are solved all at once (Jacobi): each vertex is split into as many equal masses as it has
// contacts, so that their corrections add up without overshooting [mass splitting: Tonge et al. 2012], and
// impulses are kept from step to step, so that a stack at rest needs no iterations at all.
#include <algorithm>
#include <bit>
#include <cmath>

#include "turgor/models/cloth/contact/contact_kernels.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 256;
/// Solved with the sheet, as all that touches its vertices: it has its impulse already.
bool is_settled(const Contacts& contacts, const Contact& c) {
  if (!c.is_implicit) return false;
  for (const int v : c.vertex) {
    if (v < 0) continue;
    for (int n = contacts.begin[std::size_t(v)]; n < contacts.begin[std::size_t(v) + 1]; n++)
      if (!contacts.list[std::size_t(contacts.item[std::size_t(n)]) / 4].is_implicit) return false;
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

void impulse_delta(const Exec& exec, State& state, Vectors& field) {
  const std::vector<int>& touched = state.contacts.touched;
  const ImpulseDelta impulse_delta{view(state.contacts), state.free_mass.data(), view(field)};
  parallel_for(
      exec, touched.size(), [&](std::size_t n) { impulse_delta(std::size_t(touched[n])); }, kGrain);
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
  for (Contact& c : list) c.mass = contact_mass(c, begin.data(), state.free_mass.data());
}

int solve_velocities(const Exec& exec, const Model& model, State& state, double dt) {
  Contacts& contacts = state.contacts;
  const Collision& params = model.params.collision;
  if (contacts.list.empty()) return 0;
  bool was_near = false;
  for (Contact& c : contacts.list) start_impulse(c);
  const std::vector<std::size_t> open = unsettled(contacts);
  for (int iteration = 1; iteration <= params.iterations; iteration++) {
    std::uint32_t largest = 0;
    const bool is_last = iteration == params.iterations || was_near;
    const Real beyond = is_last ? 0 : beyond_of(iteration);
    const ConstVectorsView v = view(state.v);
    parallel_for(
        exec, open.size(),
        [&](std::size_t n) {
          Contact& c = contacts.list[open[n]];
          atomic_max(largest, magnitude_bits(update_impulse(c, v, Real(dt), beyond)));
        },
        kGrain);
    impulse_delta(exec, state, state.v);
    was_near = std::bit_cast<Real>(largest) < small_speed(params, dt);
    if (is_last) {
      for (Contact& c : contacts.list) set_carry(c, state.free_mass.data(), largest_carried(params, dt));
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
    std::uint32_t largest = 0;
    const Real beyond = iteration == params.iterations ? 0 : beyond_of(iteration);
    const ConstVectorsView x = view(state.x);
    parallel_for(
        exec, contacts.list.size(),
        [&](std::size_t c) {
          atomic_max(largest, magnitude_bits(update_place(contacts.list[c], x, Real(dt), beyond)));
        },
        kGrain);
    impulse_delta(exec, state, state.x);
    was_near = std::bit_cast<Real>(largest) < small_way(params);
  }
}

Vec3d place_of(const State& state, const Contact& c) {
  Vec3d place;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) place += Vec3d(state.x[std::size_t(c.vertex[k])]) * double(c.weight[k]);
  return place;
}

ObstacleLoad obstacle_load(const State& state, int obstacle, Vec3d center) {
  ObstacleLoad load;
  for (const Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle) continue;
    const Vec3d impulse = impulse_on_obstacle(c);
    load.impulse += impulse;
    load.moment += cross(place_of(state, c) - center, impulse);
  }
  return load;
}

}  // namespace turgor::cloth
