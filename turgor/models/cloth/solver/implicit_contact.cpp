#include "turgor/models/cloth/solver/implicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/free_obstacle.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {

namespace {

constexpr double kContactStiffness = 50;  // contact stiffness relative to the resistance of its vertices
constexpr double kSelfContactStiffness =
    20;  // the same for self-contacts, where higher values need more iterations
constexpr double kFrictionTolerance = 0.01;  // error of friction allowed in a step, relative to all friction
constexpr double kTensionTolerance = 0.01;   // tension of contacts that open, relative to all normal impulses
constexpr Real kPenetrationTolerance =
    Real(0.02);  // penetration of a closed contact allowed in a step, relative to the thickness

/// Weighted sum of a field at the vertices of a contact.
Vec3 weighted(const Contact& c, const Vectors& field) {
  Vec3 sum;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) sum += field[std::size_t(c.vertex[k])] * c.weight[k];
  return sum;
}

/// Product with a symmetric matrix: xx yy zz xy xz yz.
Vec3d times(const std::array<double, 6>& m, Vec3d a) {
  return {m[0] * a.x + m[3] * a.y + m[4] * a.z, m[3] * a.x + m[1] * a.y + m[5] * a.z,
          m[4] * a.x + m[5] * a.y + m[2] * a.z};
}

/// Updates the inverse of M to that of M + k n nᵀ [Sherman, Morrison].
void add_rank_one(std::array<double, 6>& inverse, Vec3d n, double k) {
  TURGOR_CHECK(!(k < 0), "contacts are not negatively stiff");
  const Vec3d a = times(inverse, n);
  const double s = k / (1 + k * dot(a, n));
  inverse[0] -= s * a.x * a.x, inverse[1] -= s * a.y * a.y, inverse[2] -= s * a.z * a.z;
  inverse[3] -= s * a.x * a.y, inverse[4] -= s * a.x * a.z, inverse[5] -= s * a.y * a.z;
}

std::array<double, 6> diagonal_inverse(const System& system, std::size_t v) {
  const Vec3d d(system.inverse[0][v]), o(system.inverse[1][v]);
  return {d.x, d.y, d.z, o.x, o.y, o.z};
}

/// Normal velocity u_min that uses up the gap of a contact in the step [m/s].
Real min_normal_speed(const Contact& c, const ImplicitContact& a, double dt) {
  return dot(c.obstacle_velocity, c.normal) + a.separation_speed - std::max(c.gap, Real(0)) / Real(dt);
}

/// Tangential component of a velocity relative to the obstacle.
Vec3 across(const Contact& c, Vec3 u) {
  return u - c.obstacle_velocity - c.normal * dot(u - c.obstacle_velocity, c.normal);
}

/// Sets the terms of a contact for the next solution. A sliding contact has the tangential stiffness μ
/// λ/|u_t|, with u the latest known velocity, so that its friction is Coulomb's at that speed [lagged
/// diffusivity: Kačanov]. A sticking one starts from its friction impulse.
void set_terms(const Contact& c, const State& state, double dt, bool is_closed, bool slips, Vec3 u,
               ImplicitContact& a) {
  // open contact
  a.normal_stiffness = a.tangential_stiffness = 0, a.load = {};
  if (!is_closed) return;
  // stick or slip
  const Vec3 aside = across(c, u);
  const Real limit = c.friction * c.impulse, speed = norm(aside);
  const bool slides = a.stick_stiffness * speed > limit;
  a.normal_stiffness = a.closed_stiffness, a.stick_impulse = slides ? Vec3{} : c.friction_impulse;
  a.tangential_stiffness = limit == 0                                     ? 0
                           : slides                                       ? limit / speed
                           : slips && dot(aside, c.friction_impulse) <= 0 ? 0
                                                                          : a.stick_stiffness;
  // impulse at zero velocity change
  const Vec3 before = weighted(c, state.v);
  a.load =
      c.normal * (c.impulse + a.normal_stiffness * (min_normal_speed(c, a, dt) - dot(before, c.normal))) +
      a.stick_impulse - across(c, before) * a.tangential_stiffness;
}

/// Adds the contacts to the inverse diagonal blocks of their vertices.
void update_diagonal(State& state) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  TURGOR_CHECK(state.implicit_contacts.inverse.size() == contacts.touched.size(),
               "every touched vertex has a diagonal");
  for (std::size_t n = 0; n < contacts.touched.size(); n++) {
    const auto v = std::size_t(contacts.touched[n]);
    if (state.free_mass[v] == 0) continue;
    // rank-one updates of the inverse by each contact: normal, then two tangents
    std::array<double, 6> inverse = state.implicit_contacts.inverse[n];
    for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
      const auto item = std::size_t(contacts.item[std::size_t(m)]);
      const Contact& c = contacts.list[item / 4];
      const ImplicitContact& a = state.implicit_contacts.terms[item / 4];
      const double w = double(c.weight[item % 4]);
      const Vec3d normal(c.normal);
      if (a.normal_stiffness > 0) add_rank_one(inverse, normal, w * w * double(a.normal_stiffness));
      if (!(a.tangential_stiffness > 0)) continue;
      const Vec3d aside = std::abs(normal.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
      const Vec3d t = normalized(cross(normal, aside));
      for (const Vec3d tangent : {t, cross(normal, t)})
        add_rank_one(inverse, tangent, w * w * double(a.tangential_stiffness));
    }
    // the rounding of six entries to single precision must keep it positive definite
    constexpr double kRounding = 2e-7;  // above three units in the last digit, relative to the trace
    const double floor = kRounding * (inverse[0] + inverse[1] + inverse[2]);
    state.system.inverse[0].set(v, Vec3(Vec3d{inverse[0] + floor, inverse[1] + floor, inverse[2] + floor}));
    state.system.inverse[1].set(v, Vec3(Vec3d{inverse[3], inverse[4], inverse[5]}));
  }
}

/// Resistance of a contact's vertices to its normal [kg]: 1 / (n · Σ m w² D⁻¹ n) with the diagonal blocks D.
/// For self-contacts m is the number of contacts of a vertex, so that together these are no stiffer than one;
/// else 1.
double resistance(const Contact& c, const State& state) {
  const std::vector<int>& begin = state.implicit_contacts.contacts.begin;
  double mobility = 0;
  for (std::size_t k = 0; k < 4; k++) {
    if (c.vertex[k] < 0 || state.free_mass[std::size_t(c.vertex[k])] == 0) continue;
    const auto v = std::size_t(c.vertex[k]);
    const double w = double(c.weight[k]), shares = c.obstacle < 0 ? begin[v + 1] - begin[v] : 1;
    const Vec3d n(c.normal);
    mobility += shares * w * w * dot(n, times(diagonal_inverse(state.system, v), n));
  }
  return mobility > 0 ? 1 / mobility : 0;
}

/// True if an obstacle presses the cloth at this contact, or will in the step.
bool presses(const Contact& c, const State& state, double dt) {
  return c.obstacle >= 0 &&
         (c.impulse > 0 || dot(weighted(c, state.v), c.normal) < min_normal_speed(c, {}, dt));
}

/// Marks vertices that are pressed by several obstacles.
std::vector<char> squeezed_vertices(const State& state, double dt) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  std::vector<char> squeezed(contacts.begin.size(), 0);
  for (const int v : contacts.touched) {
    int first = -1;
    for (int m = contacts.begin[std::size_t(v)]; m < contacts.begin[std::size_t(v) + 1]; m++) {
      const Contact& c = contacts.list[std::size_t(contacts.item[std::size_t(m)]) / 4];
      if (!presses(c, state, dt)) continue;
      if (first >= 0 && first != c.obstacle) squeezed[std::size_t(v)] = 1;
      first = c.obstacle;
    }
  }
  return squeezed;
}

/// Number of pressing contacts of an obstacle, and of those with another obstacle pressing too.
struct Pressing {
  int all = 0, squeezed = 0;
};

/// Softens contacts of cloth that is squeezed between two obstacles, such as a tool and a body. The cloth
/// cannot move out of both, and penetration shows that their forces are too small. The body yields to these a
/// frame later, so contacts must not be stiffer than the body: it would bounce.
void soften_squeezed(const Inputs& inputs, double dt, State& state) {
  constexpr Real kSeparationRate = Real(0.25);  // fraction of the penetration that a step removes
  // squeezed vertices
  std::vector<Contact>& list = state.implicit_contacts.contacts.list;
  const std::vector<char> squeezed = squeezed_vertices(state, dt);
  const auto is_squeezed = [&squeezed](const Contact& c) {
    return std::any_of(c.vertex.begin(), c.vertex.end(),
                       [&](int v) { return v >= 0 && squeezed[std::size_t(v)] != 0; });
  };
  // pressing contacts of each obstacle
  std::vector<Pressing> pressing(inputs.obstacles.size());
  for (const Contact& c : list)
    if (presses(c, state, dt)) {
      TURGOR_CHECK(is_index(c.obstacle, pressing.size()), "a contact is with an obstacle of the step");
      Pressing& counts = pressing[std::size_t(c.obstacle)];
      counts.all++, counts.squeezed += is_squeezed(c);
    }
  bool any_compliant = false;
  for (std::size_t o = 0; o < pressing.size(); o++)
    any_compliant = any_compliant || (pressing[o].squeezed > 0 && inputs.obstacles[o].compliance > 0);
  // compliance of the body in series with the contacts
  for (std::size_t n = 0; n < list.size() && any_compliant; n++) {
    Contact& c = list[n];
    ImplicitContact& a = state.implicit_contacts.terms[n];
    if (c.obstacle < 0 || !(a.closed_stiffness > 0)) continue;
    const auto [all, squeezed_count] = pressing[std::size_t(c.obstacle)];
    const double compliance = inputs.obstacles[std::size_t(c.obstacle)].compliance / (dt * dt);
    const bool is_between = is_squeezed(c);
    if (is_between) a.separation_speed = kSeparationRate * std::max(-c.gap, Real(0)) / Real(dt);
    if (squeezed_count == 0 || compliance == 0) continue;
    a.stick_stiffness = Real(1 / (1 / double(a.stick_stiffness) + compliance * all));
    a.closed_stiffness =
        Real(1 / (1 / double(a.closed_stiffness) + compliance * (is_between ? squeezed_count : all)));
    if (is_between) c.plane = std::numeric_limits<Real>::lowest();  // no position impulse: the body yields
  }
}

}  // namespace

void find_implicit_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                            double dt, std::span<const Contact> collisions) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  // predicted contacts
  find_step_contacts(exec, model, state, inputs, ContactPhase::kPredicted, dt,
                     implicit_contacts.contacts.candidates);
  std::vector<Contact>& list = implicit_contacts.contacts.list;
  list.clear();
  for (const auto& found : implicit_contacts.contacts.candidates)
    list.insert(list.end(), found.begin(), found.end());
  link_contacts(model, state, implicit_contacts.contacts);
  // collisions of earlier solutions of the step
  const std::size_t predicted = list.size();
  for (const Contact& c : collisions)
    if (!find_previous(view(implicit_contacts.contacts), c)) list.push_back(c);
  if (list.size() > predicted) link_contacts(model, state, implicit_contacts.contacts);
  // terms with their stiffness
  implicit_contacts.terms.assign(list.size(), {});
  implicit_contacts.inverse.clear();
  for (const int v : implicit_contacts.contacts.touched)
    implicit_contacts.inverse.push_back(diagonal_inverse(state.system, std::size_t(v)));
  for (std::size_t n = 0; n < list.size(); n++)
    implicit_contacts.terms[n].closed_stiffness = implicit_contacts.terms[n].stick_stiffness =
        Real((list[n].obstacle < 0 ? kSelfContactStiffness : kContactStiffness) * resistance(list[n], state));
  find_free_obstacles(inputs, state);
  if (inputs.obstacles.size() > 1 && !list.empty()) soften_squeezed(inputs, dt, state);
  // initial active set: warm-started or closing contacts
  for (std::size_t n = 0; n < list.size(); n++) {
    Contact& c = list[n];
    ImplicitContact& terms = implicit_contacts.terms[n];
    c.is_implicit = true;
    const Vec3 u = weighted(c, state.v);
    const bool closes = dot(u, c.normal) < min_normal_speed(c, terms, dt);
    const bool slips = norm(c.friction_impulse) >= Real(0.999) * c.friction * c.impulse;
    set_terms(c, state, dt, c.impulse > 0 || closes, slips, u, terms);
  }
  factor_free_obstacles(state);
  if (!list.empty()) update_diagonal(state);
}

void add_contacts_to_diagonal(State& state) {
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  for (std::size_t n = 0; n < implicit_contacts.contacts.touched.size(); n++)
    implicit_contacts.inverse[n] =
        diagonal_inverse(state.system, std::size_t(implicit_contacts.contacts.touched[n]));
  update_diagonal(state);
}

bool update_active_set(const Model& model, State& state, double dt) {
  TURGOR_CHECK(state.implicit_contacts.terms.size() == state.implicit_contacts.contacts.list.size(),
               "every contact has its terms");
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  move_free_obstacles(state);
  const Real tolerance = kPenetrationTolerance * Real(model.params.collision.thickness / dt);
  bool has_changed = false;
  double friction_error = 0, all = 0;  // error of friction, and all friction [N·s]
  double tension = 0,
         all_pressure = 0;  // impulses of contacts that open, and of those that stay closed [N·s]
  for (std::size_t n = 0; n < implicit_contacts.terms.size(); n++) {
    Contact& c = implicit_contacts.contacts.list[n];
    ImplicitContact& a = implicit_contacts.terms[n];
    const bool was_closed = a.normal_stiffness > 0;
    // velocity of the solution, and its violation of the gap
    const Vec3 u = weighted(c, state.v) + weighted(c, state.system.change);
    const Real violation = min_normal_speed(c, a, dt) - dot(u, c.normal);
    bool is_closed = violation > tolerance, slips = false;
    // augmented impulse, cut to Coulomb's cone
    if (was_closed) {
      c.impulse += a.normal_stiffness * violation;
      is_closed = c.impulse > 0;
      (is_closed ? all_pressure : tension) += std::abs(double(c.impulse));
      c.friction_impulse = a.stick_impulse - across(c, u) * a.tangential_stiffness;
      const Real limit = c.friction * std::max(c.impulse, Real(0)), size = norm(c.friction_impulse);
      slips = size > Real(0.999) * limit;
      const bool slides = a.tangential_stiffness < a.stick_stiffness;
      friction_error += double(slides ? std::abs(size - limit) : std::max(Real(0), size - limit)),
          all += double(limit);
      if (size > limit) c.friction_impulse *= limit / size;
      has_changed = has_changed || violation > tolerance;
    }
    // new state of the contact
    if (!is_closed) c.impulse = 0, c.friction_impulse = {};
    has_changed = has_changed || (is_closed && !was_closed);
    set_terms(c, state, dt, is_closed, slips, u, a);
  }
  // total errors of friction and of pressure
  has_changed =
      has_changed || friction_error > kFrictionTolerance * all || tension > kTensionTolerance * all_pressure;
  factor_free_obstacles(state);
  if (has_changed) update_diagonal(state);
  return has_changed;
}

bool any_closed(const ImplicitContacts& contacts) {
  return std::any_of(contacts.terms.begin(), contacts.terms.end(),
                     [](const ImplicitContact& a) { return a.normal_stiffness > 0; });
}

bool presses_obstacle(const ImplicitContacts& contacts) {
  for (std::size_t n = 0; n < contacts.terms.size(); n++)
    if (contacts.terms[n].normal_stiffness > 0 && contacts.contacts.list[n].obstacle >= 0) return true;
  return false;
}

/// P of each closed contact is −K u, plus the load, where u is relative to free obstacles. It is found once,
/// not once for each of its vertices.
void find_impulses(const Exec& exec, State& state, const Vectors& a, bool with_loads) {
  constexpr std::size_t kGrain = 256;
  std::vector<Contact>& list = state.implicit_contacts.contacts.list;
  parallel_for(
      exec, list.size(),
      [&](std::size_t n) {
        Contact& c = list[n];
        const ImplicitContact& terms = state.implicit_contacts.terms[n];
        c.impulse_delta = {};
        if (!(terms.normal_stiffness > 0)) return;
        c.impulse_delta = resisting_impulse(c, terms, weighted(c, a));
        if (with_loads) c.impulse_delta += terms.load;
      },
      kGrain);
  if (!state.implicit_contacts.free.empty()) yield_free_obstacles(with_loads, state);
}

Lanes3 implicit_contact_terms(const State& state, std::size_t i) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  Lanes3 sum{};
  const std::size_t end = std::min(i + std::size_t(kLanes), contacts.begin.size() - 1);
  for (std::size_t v = i; v < end; v++) {
    // shares of the vertex in its contacts
    Vec3 total;
    for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
      const auto item = std::size_t(contacts.item[std::size_t(m)]);
      const Contact& c = contacts.list[item / 4];
      total += c.impulse_delta * c.weight[item % 4];
    }
    const std::size_t l = v - i;
    sum.x[l] = total.x, sum.y[l] = total.y, sum.z[l] = total.z;
  }
  return sum;
}

}  // namespace turgor::cloth
