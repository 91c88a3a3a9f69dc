#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/contact_loops.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 8;  // chunks of vertices

struct FindPairs {
  const State& state;
  PairsView pairs;
  Look look;
  Real reach;

  void operator()(int i, std::vector<Contact>& found) const {
    const Group mine = pairs.group(i);
    visit_near(state.near_points, pairs.x[std::size_t(i)], reach, [&](int j, Vec3 xj) {
      if (j <= i) return;
      Contact contact;
      if (pairs.touch(i, mine, j, xj, look, contact) && !is_borne_already(state, contact, look))
        found.push_back(contact);
    });
  }
};

struct FindObstacles {
  const Model& model;
  const State& state;
  const std::vector<Obstacle>& obstacles;
  Real dt;

  /// Whether a place of the cloth at x with the velocity v must be kept from an obstacle.
  bool must_keep(const SurfacePoint& at, Vec3 x, Vec3 v, Real margin, const Obstacle& obstacle,
                 Contact& contact) const {
    const Contact* old = find_old(state.contacts, contact);
    const Real closing = -dt * dot(v - at.velocity, at.normal), room = at.distance - Real(obstacle.gap);
    // A vertex that does not approach by itself may be pushed there by its neighbours.
    if (room >= std::max(closing, margin) && !(old && old->impulse > 0)) return false;
    contact.normal = at.normal, contact.room = room, contact.plane = dot(at.normal, x) - room;
    contact.drift = at.velocity, contact.friction = Real(obstacle.friction);
    if (old) contact.impulse = old->impulse * old->carry, contact.rub = old->rub * old->carry;
    return true;
  }

  /// What could pass between the vertices of the triangles whose smallest vertex is i.
  void in_triangles(int i, std::vector<Contact>& found) const {
    constexpr Real kCorner = Real(0.999);  // of the weight: the vertex has its own contact
    for (int t = model.triangle_begin[std::size_t(i)]; t < model.triangle_begin[std::size_t(i) + 1]; t++) {
      const Int3 c = model.triangles[std::size_t(t)];
      const auto a = std::size_t(c.x), b = std::size_t(c.y), d = std::size_t(c.z);
      if (state.free_mass[a] + state.free_mass[b] + state.free_mass[d] == 0) continue;
      for (std::size_t o = 0; o < obstacles.size(); o++) {
        if (!obstacles[o].nearest_in) continue;
        const Real fast = std::max({norm(state.v[a]), norm(state.v[b]), norm(state.v[d])});
        const Real margin = Real(obstacles[o].gap) + dt * (fast + Real(obstacles[o].speed));
        std::array<Real, 3> w{};
        SurfacePoint at;
        if (!obstacles[o].nearest_in({state.x[a], state.x[b], state.x[d]}, 2 * margin, w, at)) continue;
        if (std::max({w[0], w[1], w[2]}) > kCorner) continue;
        Contact contact{.vertex = {c.x, c.y, c.z, -1}, .weight = {w[0], w[1], w[2], 0}, .obstacle = int(o)};
        const Vec3 x = state.x[a] * w[0] + state.x[b] * w[1] + state.x[d] * w[2];
        const Vec3 v = state.v[a] * w[0] + state.v[b] * w[1] + state.v[d] * w[2];
        if (must_keep(at, x, v, margin, obstacles[o], contact)) found.push_back(contact);
      }
    }
  }

  void operator()(int i, std::vector<Contact>& found) const {
    const auto vertex = std::size_t(i);
    if (state.free_mass[vertex] == 0) return;
    const Vec3 x = state.x[vertex], v = state.v[vertex];
    for (std::size_t o = 0; o < obstacles.size(); o++) {
      const Real margin = Real(obstacles[o].gap) + dt * (norm(v) + Real(obstacles[o].speed));
      SurfacePoint at;
      if (!obstacles[o].nearest(x, 2 * margin, at)) continue;
      Contact contact{.vertex = {i, -1, -1, -1}, .weight = {1, 0, 0, 0}, .obstacle = int(o)};
      if (must_keep(at, x, v, margin, obstacles[o], contact)) found.push_back(contact);
    }
  }
};

/// Is anything so small that it could pass between vertices?
bool finds_between(const Inputs& inputs) {
  return std::any_of(inputs.obstacles.begin(), inputs.obstacles.end(),
                     [](const Obstacle& o) { return bool(o.nearest_in); });
}

/// Contacts with obstacles, as they were solved with the sheet, that press or would with the velocities now.
void add_borne(State& state, Real dt) {
  for (const Contact& c : state.bearing.contacts.list) {
    Vec3 v;
    for (std::size_t k = 0; k < 4; k++)
      if (c.vertex[k] >= 0) v += state.v[std::size_t(c.vertex[k])] * c.weight[k];
    const Real closing = -dt * dot(v - c.drift, c.normal);
    if (c.impulse > 0 || c.room < closing) state.contacts.list.push_back(c);
  }
}

}  // namespace

bool is_borne_already(const State& state, const Contact& contact, Look look) {
  return look == Look::kLeft && find_old(state.bearing.contacts, contact);
}

void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, Look look,
                        double dt, std::vector<std::vector<Contact>>& found) {
  const Collision& params = model.params.collision;
  const std::size_t chunks = (std::size_t(model.count) + kChunk - 1) / kChunk;
  const std::size_t pieces = params.self ? coarse_pieces(model) : 0;
  found.resize(chunks + pieces + 1);
  const Real thickness = Real(params.thickness), least = look == Look::kAhead ? 1 + kSurprise : Real(1.1);
  const Real reach = reach_in_step(thickness, least, state.largest_speed, Real(dt));
  const FindPairs pairs{state, pairs_view(model, state, dt), look, reach};
  const FindObstacles obstacles{model, state, inputs.obstacles, Real(dt)};
  const bool is_whole = look == Look::kAhead || !uses_gradients(model.params.solver.method);
  const bool others = is_whole && !inputs.obstacles.empty();
  const bool between = others && finds_between(inputs);
  if (params.self) {
    const Real coarse = model.coarse.triangles.empty() ? 0 : model.coarse.longest / 2;
    sort_points(exec, state.x, model.count, std::max(Real(2.02) * reach, coarse), state.near_points);
  }
  parallel_for(
      exec, chunks,
      [&](std::size_t chunk) {
        found[chunk].clear();
        const int end = std::min(int((chunk + 1) * kChunk), model.count);
        for (int i = int(chunk * kChunk); i < end; i++) {
          if (params.self) pairs(i, found[chunk]);
          if (others) obstacles(i, found[chunk]);
          if (between) obstacles.in_triangles(i, found[chunk]);
        }
      },
      kGrain);
  if (pieces > 0)
    find_coarse_contacts(exec, model, state, look, reach, dt, std::span(found).subspan(chunks, pieces));
  found.back().clear();
  if (params.self && is_whole) find_met_contacts(model, state, look, dt, found.back());
}

void find_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  Contacts& contacts = state.contacts;
  find_step_contacts(exec, model, state, inputs, Look::kLeft, dt, contacts.found);
  contacts.list.clear();
  add_borne(state, Real(dt));
  for (const auto& found : contacts.found)
    contacts.list.insert(contacts.list.end(), found.begin(), found.end());
  link_contacts(model, state, contacts);
}

}  // namespace turgor::cloth
