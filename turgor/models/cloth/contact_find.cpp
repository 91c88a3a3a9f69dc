#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 8;   // chunks of vertices
constexpr Real kAhead = Real(0.3);  // of the thickness, by which two places may come nearer by surprise

bool is_near_at_rest(const NeighbourLists& near, int a, int b) {
  const auto from = near.item.begin() + near.begin[std::size_t(a)],
             to = near.item.begin() + near.begin[std::size_t(a) + 1];
  return std::find(from, to, b) != to;
}

struct FindPairs {
  const Model& model;
  const State& state;
  Look look;
  Real reach, dt;

  Group group(int i) const {
    const auto v = std::size_t(i);
    return {state.v[v], state.system.change[v], state.contacts.touches(i)};
  }

  void operator()(int i, std::vector<Contact>& found) const {
    const Collision& params = model.params.collision;
    const Real thickness = Real(params.thickness);
    const Vec3 xi = state.x[std::size_t(i)];
    const Group mine = group(i);
    visit_near(state.near_points, xi, reach, [&](int j, Vec3 xj) {
      if (j <= i) return;
      const Vec3 d = xi - xj;
      const Real distance = norm(d);
      const Vec3 normal = distance > 0 ? d / distance : Vec3{0, 0, 1};
      Contact contact{.vertex = {i, j, -1, -1}, .weight = {1, -1, 0, 0}};
      contact.normal = normal;
      const Contact* old = find_old(state.contacts, contact);
      if (!is_wanted(state, contact, old, look, mine, group(j), distance, thickness, dt)) return;
      if (is_near_at_rest(model.near, i, j)) return;
      contact.plane = thickness, contact.room = distance - thickness;
      contact.friction = Real(params.friction);
      if (old) contact.impulse = old->impulse * old->carry, contact.rub = old->rub * old->carry;
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

const Contact* find_old(const Contacts& contacts, const Contact& wanted) {
  const auto v = std::size_t(wanted.vertex[0]);
  if (contacts.begin.empty()) return nullptr;
  for (int n = contacts.begin[v]; n < contacts.begin[v + 1]; n++) {
    const Contact& old = contacts.list[std::size_t(contacts.item[std::size_t(n)]) / 4];
    if (old.vertex == wanted.vertex && old.obstacle == wanted.obstacle) return &old;
  }
  return nullptr;
}

bool is_wanted(const State& state, const Contact& contact, const Contact* old, Look look, const Group& a,
               const Group& b, Real distance, Real thickness, Real dt) {
  if (look == Look::kAhead)
    return distance - dt * norm(a.v - b.v) < (1 + kAhead) * thickness || (old && old->impulse > 0);
  if (distance - approach(a, b, contact.normal, dt) >= thickness && !(old && old->impulse > 0)) return false;
  return !find_old(state.bearing.contacts, contact);
}

void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, Look look,
                        double dt, std::vector<std::vector<Contact>>& found) {
  const Collision& params = model.params.collision;
  const std::size_t chunks = (std::size_t(model.count) + kChunk - 1) / kChunk;
  const std::size_t pieces = params.self ? coarse_pieces(model) : 0;
  found.resize(chunks + pieces + 1);
  // Two vertices can come as much nearer in a step as both of them move: as far is looked, within bounds.
  const Real thickness = Real(params.thickness), least = look == Look::kAhead ? 1 + kAhead : Real(1.1);
  const Real reach =
      thickness * std::clamp(1 + 2 * Real(dt) * state.largest_speed / thickness, least, Real(2));
  const FindPairs pairs{model, state, look, reach, Real(dt)};
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
