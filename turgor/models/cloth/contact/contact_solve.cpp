// Contact solver: projected Jacobi iterations over all contacts at once. Each vertex is split into equal
// masses, one per contact, so that corrections add up without overshooting [mass splitting: Tonge et al.
// 2012]. Impulses are warm started, so a stack at rest needs no iterations.
#include <algorithm>
#include <bit>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 256;
/// True for an implicit contact whose vertices have implicit contacts only: its impulse is solved already.
bool is_solved(const Contacts& contacts, const Contact& c) {
  if (!c.is_implicit) return false;
  for (const int v : c.vertex) {
    if (v < 0) continue;
    for (int n = contacts.begin[std::size_t(v)]; n < contacts.begin[std::size_t(v) + 1]; n++)
      if (!contacts.list[std::size_t(contacts.item[std::size_t(n)]) / 4].is_implicit) return false;
  }
  return true;
}

/// Contacts whose impulses are not solved yet.
std::vector<std::size_t> unsolved_contacts(const Contacts& contacts) {
  std::vector<std::size_t> list;
  for (std::size_t c = 0; c < contacts.list.size(); c++)
    if (!is_solved(contacts, contacts.list[c])) list.push_back(c);
  return list;
}

void impulse_delta(const Exec& exec, State& state, Vectors& field) {
  const std::vector<int>& touched = state.contacts.touched;
  const ImpulseDelta impulse_delta{view(state.contacts), state.free_mass.data(), view(field)};
  parallel_for(
      exec, touched.size(), [&](std::size_t n) { impulse_delta(std::size_t(touched[n])); }, kGrain);
}

}  // namespace

void list_by_vertex(int count, Contacts& contacts) {
  auto& list = contacts.list;
  auto &begin = contacts.begin, &item = contacts.item, &touched = contacts.touched;
  touched.clear(), begin.clear();
  if (list.empty()) return;
  // number of contacts per vertex, shifted by two
  begin.assign(std::size_t(count) + 2, 0);
  std::size_t uses = 0;
  for (const Contact& c : list)
    for (const int v : c.vertex)
      if (v >= 0) begin[std::size_t(v) + 2]++, uses++;
  // touched vertices, and offsets
  for (std::size_t i = 2; i < begin.size(); i++) {
    if (begin[i] > 0) touched.push_back(int(i) - 2);
    begin[i] += begin[i - 1];
  }
  // contacts of each vertex
  item.resize(uses);
  for (std::size_t c = 0; c < list.size(); c++)
    for (std::size_t k = 0; k < 4; k++)
      if (const int v = list[c].vertex[k]; v >= 0)
        item[std::size_t(begin[std::size_t(v) + 1]++)] = int(4 * c + k);
  begin.pop_back();
  TURGOR_CHECK(is_csr(begin, item.size()), "every vertex has the list of its contacts");
}

void link_contacts(const Model& model, const State& state, Contacts& contacts) {
  auto& list = contacts.list;
  TURGOR_CHECK(std::all_of(list.begin(), list.end(),
                           [&](const Contact& c) {
                             return c.vertex[0] >= 0 && std::all_of(c.vertex.begin(), c.vertex.end(),
                                                                    [&](int v) { return v < model.count; });
                           }),
               "contacts are of vertices of the cloth");
  TURGOR_CHECK(std::all_of(list.begin(), list.end(),
                           [](const Contact& c) {
                             return std::abs(c.weight[0] + c.weight[1] + c.weight[2] + c.weight[3] -
                                             Real(c.obstacle >= 0 ? 1 : 0)) < Real(1e-3);
                           }),
               "the weights of a contact sum to 0, or to 1 against an obstacle");
  TURGOR_CHECK(std::all_of(list.begin(), list.end(),
                           [](const Contact& c) { return c.obstacle >= 0 || is_unit(c.normal); }),
               "the normal of a self-contact is a unit vector");
  list_by_vertex(model.count, contacts);
  // effective masses
  for (Contact& c : list) c.mass = contact_mass(c, contacts.begin.data(), state.free_mass.data());
}

int solve_velocities(const Exec& exec, const Model& model, State& state, double dt) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  Contacts& contacts = state.contacts;
  const Collision& params = model.params.collision;
  if (contacts.list.empty()) return 0;
  // warm start
  bool has_converged = false;
  for (Contact& c : contacts.list) start_impulse(c);
  const std::vector<std::size_t> unsolved = unsolved_contacts(contacts);
  // overrelaxed Jacobi iterations; one more without overrelaxation after convergence
  for (int iteration = 1; iteration <= params.iterations; iteration++) {
    std::uint32_t largest = 0;
    const bool is_last = iteration == params.iterations || has_converged;
    const Real relaxation = is_last ? 0 : overrelaxation(iteration);
    const ConstVectorsView v = view(state.v);
    parallel_for(
        exec, unsolved.size(),
        [&](std::size_t n) {
          Contact& c = contacts.list[unsolved[n]];
          atomic_max(largest, magnitude_bits(update_impulse(c, v, Real(dt), relaxation)));
        },
        kGrain);
    impulse_delta(exec, state, state.v);
    has_converged = std::bit_cast<Real>(largest) < velocity_tolerance(params, dt);
    if (is_last) {
      // impulses that the next step starts with
      for (Contact& c : contacts.list)
        set_warm_start(c, state.free_mass.data(), largest_warm_start(params, dt));
      return iteration;
    }
  }
  return 0;
}

void solve_positions(const Exec& exec, const Model& model, State& state, double dt) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  Contacts& contacts = state.contacts;
  const Collision& params = model.params.collision;
  if (contacts.list.empty()) return;
  bool has_converged = false;
  // overrelaxed Jacobi iterations
  for (int iteration = 1; iteration <= params.iterations && !has_converged; iteration++) {
    std::uint32_t largest = 0;
    const Real relaxation = iteration == params.iterations ? 0 : overrelaxation(iteration);
    const ConstVectorsView x = view(state.x);
    parallel_for(
        exec, contacts.list.size(),
        [&](std::size_t c) {
          atomic_max(largest,
                     magnitude_bits(update_position_impulse(contacts.list[c], x, Real(dt), relaxation)));
        },
        kGrain);
    impulse_delta(exec, state, state.x);
    has_converged = std::bit_cast<Real>(largest) < position_tolerance(params);
  }
}

Vec3d contact_position(const State& state, const Contact& c) {
  Vec3d position;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) position += Vec3d(state.x[std::size_t(c.vertex[k])]) * double(c.weight[k]);
  return position;
}

ObstacleLoad obstacle_load(const State& state, int obstacle, Vec3d center) {
  TURGOR_CHECK(obstacle >= 0, "a load is on an obstacle");
  ObstacleLoad load;
  for (const Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle) continue;
    const Vec3d impulse = impulse_on_obstacle(c);
    load.impulse += impulse;
    load.moment += cross(contact_position(state, c) - center, impulse);
  }
  return load;
}

}  // namespace turgor::cloth
