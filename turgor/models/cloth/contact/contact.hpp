// Contacts of a cloth with itself and with obstacles: who touches whom, and the impulses that keep them
// apart. A contact holds up to four vertices whose weighted sum must stay on the positive side of a plane:
// two vertices, a vertex and a triangle, two edges, or a vertex alone against an obstacle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct Model;
struct State;
struct Inputs;

/// Numbers in lists: of vertex i those from begin[i] to begin[i + 1].
struct NeighborLists {
  std::vector<int> begin, item;
};

/// What is large compared to the thickness: vertices alone would not keep it apart.
struct LargePrimitives {
  std::vector<Int3> triangles;
  std::vector<std::array<int, 2>> edges;
  Real longest = 0;  // edge, at rest [m]
};

struct Contact {
  std::array<int, 4> vertex{-1, -1, -1, -1};
  std::array<Real, 4> weight{};  // their sum is 0, or 1 against an obstacle
  int obstacle = -1;             // which one of the inputs; -1 = the cloth itself
  Vec3 normal;                   // towards the side of the first vertex
  Real room = 0;          // how far the weighted sum may still go against the normal; negative = too near [m]
  Real plane = 0;         // normal · weighted sum where the room ends [m]
  Vec3 drift;             // velocity of the obstacle [m/s]
  Real friction = 0;      // [1]
  Real mass = 0;          // that an impulse moves, with every vertex split among its contacts [kg]
  Real impulse = 0;       // along the normal [N·s]
  Vec3 friction_impulse;  // across it: friction [N·s]
  Real warm_start = 0;    // part of both that the next step begins with [1]
  bool is_implicit = false;  // it was solved with the sheet (implicit_contact.hpp)
  Vec3 allowed;              // impulse of the latest iteration before it is extrapolated [N·s]
  Real position_impulse = 0, position_impulse_allowed = 0;  // the same for places, from 0 in each step [kg·m]
  Vec3 impulse_delta;  // change of the impulse in the present iteration [N·s]
};

struct Contacts {
  std::vector<Contact> list;
  std::vector<int> begin, item;  // contacts of each vertex: item[begin[i]] … item[begin[i + 1] - 1]
  std::vector<int> touched;      // vertices that have any
  std::vector<std::vector<Contact>> found;  // by chunk, while looking
  SpatialHash midpoints;                    // of coarse edges, sorted [m]
  Vectors middles;                          // the same as they come; then these edges from end to end [m]
  Real longest_half = 0;                    // half of the longest coarse edge [m]

  bool touches(int vertex) const {
    const auto v = std::size_t(vertex);
    return !begin.empty() && begin[v] < begin[v + 1];
  }
};

/// The contacts that the velocities of a step make, with those that were solved with it.
void find_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Which contacts of a cloth with itself are looked for.
enum class Look : std::uint8_t {
  kPredicted,  // what may come too near in a step whose velocities are not known yet
  kActual      // what does with the velocities of the step, but for what was solved with it
};

/// All that is looked for in a step from x with the velocities v, by pieces of the cloth; impulses are those
/// of Contacts::list. Obstacles are among kLeft where no bearing is solved.
void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, Look look,
                        double dt, std::vector<std::vector<Contact>>& found);
/// Those of a vertex and a large triangle and of two large edges, in as many pieces as coarse_pieces says.
void find_coarse_contacts(const Exec& exec, const Model& model, State& state, Look look, Real reach,
                          double dt, std::span<std::vector<Contact>> found);
std::size_t coarse_pieces(const Model& model);
/// Those of what would have met in steps before, as long as it is nearer than the thickness.
void find_met_contacts(const Model& model, State& state, Look look, double dt, std::vector<Contact>& found);

/// How far two groups of vertices may approach each other in a step, along the normal towards the first [m].
/// `v` and `change` are their mean velocities and how much of it is new; what touched something may be
/// stopped again, and what is new may be.
struct Group {
  Vec3 v, change;
  bool touches = false;
};
TURGOR_HD inline Real approach(const Group& a, const Group& b, Vec3 normal, Real dt) {
  const Real va = -dot(a.v, normal), vb = dot(b.v, normal);
  const Real alone_a = a.touches || b.touches ? va : -dot(a.change, normal);
  const Real alone_b = a.touches || b.touches ? vb : dot(b.change, normal);
  return dt * std::max(va + vb, std::max(alone_a, alone_b));
}

/// Contacts as plain pointers, here or on a GPU.
struct ContactsView {
  const Contact* list;
  const int *begin, *item;  // begin is null where there are none

  TURGOR_HD bool touches(int vertex) const { return begin != nullptr && begin[vertex] < begin[vertex + 1]; }
};
inline ContactsView view(const Contacts& contacts) {
  return {contacts.list.data(), contacts.begin.empty() ? nullptr : contacts.begin.data(),
          contacts.item.data()};
}

constexpr Real kSurprise = Real(0.3);  // of the thickness, by which two places may come nearer unforeseen

/// Whether a contact between two groups at a distance is one of those that are looked for, `old` being the
/// same one in the step before.
TURGOR_HD inline bool is_wanted(Vec3 normal, const Contact* old, Look look, const Group& a, const Group& b,
                                Real distance, Real thickness, Real dt) {
  if (look == Look::kPredicted)
    return distance - dt * norm(a.v - b.v) < (1 + kSurprise) * thickness || (old && old->impulse > 0);
  return distance - approach(a, b, normal, dt) < thickness || (old && old->impulse > 0);
}

/// Was it solved with the sheet (implicit_contact.hpp), and is not looked for again?
bool is_implicit_already(const State& state, const Contact& contact, Look look);

/// The contact of the same vertices in the step before; null = there was none.
TURGOR_HD inline const Contact* find_old(const ContactsView& contacts, const Contact& wanted) {
  const int v = wanted.vertex[0];
  if (contacts.begin == nullptr) return nullptr;
  for (int n = contacts.begin[v]; n < contacts.begin[v + 1]; n++) {
    const Contact& old = contacts.list[contacts.item[n] / 4];
    bool same = old.obstacle == wanted.obstacle;
    for (std::size_t k = 0; k < 4; k++) same = same && old.vertex[k] == wanted.vertex[k];
    if (same) return &old;
  }
  return nullptr;
}
inline const Contact* find_old(const Contacts& contacts, const Contact& wanted) {
  return find_old(view(contacts), wanted);
}

/// Makes the lists of each vertex, and the masses, of Contacts::list.
void link_contacts(const Model& model, const State& state, Contacts& contacts);

/// Changes velocities until nothing approaches further than it has room. Returns the iterations it took.
int solve_velocities(const Exec& exec, const Model& model, State& state, double dt);
/// Moves what is still too near apart, without giving it velocity.
void solve_places(const Exec& exec, const Model& model, State& state, double dt);

/// What the obstacle of a contact got in the latest step [N·s].
inline Vec3d impulse_on_obstacle(const Contact& c) {
  return -Vec3d(c.normal * c.impulse + c.friction_impulse);
}

/// Where a contact is: the weighted places of its vertices, against an obstacle [m].
Vec3d place_of(const State& state, const Contact& c);

/// Total impulse that an obstacle got in the latest step [N·s], and its moment about `centre` [N·m·s].
struct ObstacleLoad {
  Vec3d impulse, moment;
};
ObstacleLoad obstacle_load(const State& state, int obstacle, Vec3d center);

}  // namespace turgor::cloth
