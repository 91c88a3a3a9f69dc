#include <algorithm>
#include <cmath>

#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/contact/obstacle_kernels.hpp"

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
    visit_near(state.spatial_hash, pairs.x[std::size_t(i)], reach, [&](int j, Vec3 xj) {
      if (j <= i) return;
      Contact contact;
      if (pairs.touch(i, mine, j, xj, look, contact) && !is_implicit_already(state, contact, look))
        found.push_back(contact);
    });
  }
};

struct FindObstacles {
  FacingView facing;
  const std::vector<Obstacle>& obstacles;
  bool between;  // is anything so small that it could pass between vertices?

  void operator()(int i, std::vector<Contact>& found) const {
    const auto obstacle = [&](int o) -> const ObstacleView& { return obstacles[std::size_t(o)]; };
    const auto take = [&](const Contact& contact) { found.push_back(contact); };
    facing.visit(i, int(obstacles.size()), obstacle, take);
    if (between) facing.visit_between(i, int(obstacles.size()), obstacle, take);
  }
};

/// Contacts with obstacles, as they were solved with the sheet, that press or would with the velocities now.
void add_borne(State& state, Real dt) {
  for (const Contact& c : state.implicit_contacts.contacts.list) {
    Vec3 v;
    for (std::size_t k = 0; k < 4; k++)
      if (c.vertex[k] >= 0) v += state.v[std::size_t(c.vertex[k])] * c.weight[k];
    const Real closing = -dt * dot(v - c.drift, c.normal);
    if (c.impulse > 0 || c.room < closing) state.contacts.list.push_back(c);
  }
}

}  // namespace

bool is_implicit_already(const State& state, const Contact& contact, Look look) {
  return look == Look::kActual && find_old(state.implicit_contacts.contacts, contact);
}

void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, Look look,
                        double dt, std::vector<std::vector<Contact>>& found) {
  const Collision& params = model.params.collision;
  const std::size_t chunks = (std::size_t(model.count) + kChunk - 1) / kChunk;
  const std::size_t pieces = params.self ? coarse_pieces(model) : 0;
  found.resize(chunks + pieces + 1);
  const Real thickness = Real(params.thickness), least = look == Look::kPredicted ? 1 + kSurprise : Real(1.1);
  const Real reach = reach_in_step(thickness, least, state.largest_speed, Real(dt));
  const FindPairs pairs{state, pairs_view(model, state, dt), look, reach};
  const FindObstacles obstacles{facing_view(model, state, dt), inputs.obstacles,
                                any_between(inputs.obstacles)};
  const bool is_whole = look == Look::kPredicted || !uses_gradients(model.params.solver.method);
  const bool others = is_whole && !inputs.obstacles.empty();
  if (params.self) {
    const Real coarse = model.coarse.triangles.empty() ? 0 : model.coarse.longest / 2;
    sort_points(exec, state.x, model.count, std::max(Real(2.02) * reach, coarse), state.spatial_hash);
  }
  parallel_for(
      exec, chunks,
      [&](std::size_t chunk) {
        found[chunk].clear();
        const int end = std::min(int((chunk + 1) * kChunk), model.count);
        for (int i = int(chunk * kChunk); i < end; i++) {
          if (params.self) pairs(i, found[chunk]);
          if (others) obstacles(i, found[chunk]);
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
  find_step_contacts(exec, model, state, inputs, Look::kActual, dt, contacts.found);
  contacts.list.clear();
  add_borne(state, Real(dt));
  for (const auto& found : contacts.found)
    contacts.list.insert(contacts.list.end(), found.begin(), found.end());
  link_contacts(model, state, contacts);
}

}  // namespace turgor::cloth
