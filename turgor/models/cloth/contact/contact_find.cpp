#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/contact/obstacle_kernels.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 8;  // chunks of vertices

struct FindPairs {
  const State& state;
  PairsView pairs;
  ContactPhase phase;
  Real reach;

  void operator()(int i, std::vector<Contact>& found) const {
    const Group mine = pairs.group(i);
    visit_near(state.spatial_hash, pairs.x[std::size_t(i)], reach, [&](int j, Vec3 xj) {
      if (j <= i) return;
      Contact contact{.vertex = {i, j, -1, -1}};
      if (!is_implicit_already(state, contact, phase) && pairs.touch(i, mine, j, xj, phase, contact))
        found.push_back(contact);
    });
  }
};

struct FindObstacles {
  FacingView facing;
  const std::vector<Obstacle>& obstacles;
  bool between;  // any obstacle may pass between vertices

  void operator()(int i, std::vector<Contact>& found) const {
    const auto obstacle = [&](int o) -> const ObstacleView& { return obstacles[std::size_t(o)]; };
    const auto take = [&](const Contact& contact) { found.push_back(contact); };
    facing.visit(i, int(obstacles.size()), obstacle, take);
    if (between) facing.visit_between(i, int(obstacles.size()), obstacle, take);
  }
};

/// Adds implicit contacts that press, or approach with the current velocities.
void add_implicit_contacts(State& state, Real dt) {
  for (const Contact& c : state.implicit_contacts.contacts.list) {
    Vec3 v;
    for (std::size_t k = 0; k < 4; k++)
      if (c.vertex[k] >= 0) v += state.v[std::size_t(c.vertex[k])] * c.weight[k];
    const Real closing = -dt * dot(v - c.obstacle_velocity, c.normal);
    if (c.impulse > 0 || c.gap < closing) state.contacts.list.push_back(c);
  }
}

}  // namespace

bool is_implicit_already(const State& state, const Contact& contact, ContactPhase phase) {
  return phase == ContactPhase::kActual && find_previous(state.implicit_contacts.contacts, contact);
}

void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                        ContactPhase phase, double dt, std::vector<std::vector<Contact>>& found) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  // chunks and search distance
  const Collision& params = model.params.collision;
  const std::size_t chunks = (std::size_t(model.count) + kChunk - 1) / kChunk;
  const std::size_t large = params.self ? large_chunks(model) : 0;
  found.resize(chunks + large + 1);
  const Real thickness = Real(params.thickness),
             least = phase == ContactPhase::kPredicted ? 1 + kPredictionMargin : Real(1.1);
  const Real reach = reach_in_step(thickness, least, state.largest_speed, Real(dt));
  TURGOR_CHECK(reach >= thickness, "contacts are sought at least within the thickness");
  // searches of vertices and of obstacles
  const FindPairs pairs{state, pairs_view(model, state, dt), phase, reach};
  const FindObstacles obstacles{facing_view(model, state, dt), inputs.obstacles,
                                any_between(inputs.obstacles)};
  const bool is_whole =
      phase == ContactPhase::kPredicted || !uses_conjugate_gradients(model.params.solver.method);
  const bool others = is_whole && !inputs.obstacles.empty();
  // spatial hash; the actual search uses that of the predicted one
  const bool is_sorted = phase == ContactPhase::kActual && state.contacts.near_reach >= reach;
  if (params.self && !is_sorted) {
    const Real large_cell = model.large.triangles.empty() ? 0 : model.large.longest / 2;
    sort_points(exec, state.x, model.count, std::max(Real(2.02) * reach, large_cell), state.spatial_hash);
  }
  // vertices
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
  // large primitives, and pairs of earlier CCD
  if (large > 0)
    find_large_contacts(exec, model, state, phase, reach, dt, std::span(found).subspan(chunks, large));
  state.contacts.near_reach = params.self && phase == ContactPhase::kPredicted ? reach : 0;
  found.back().clear();
  if (params.self && is_whole) find_ccd_contacts(model, state, phase, dt, found.back());
}

void find_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt) {
  TURGOR_CHECK(std::isfinite(state.largest_speed), "contacts are sought at finite speeds");
  Contacts& contacts = state.contacts;
  find_step_contacts(exec, model, state, inputs, ContactPhase::kActual, dt, contacts.candidates);
  contacts.list.clear();
  add_implicit_contacts(state, Real(dt));
  for (const auto& found : contacts.candidates)
    contacts.list.insert(contacts.list.end(), found.begin(), found.end());
  link_contacts(model, state, contacts);
}

}  // namespace turgor::cloth
