#include "turgor/models/cloth/solver/implicit_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {

namespace {

constexpr double kFirmness = 50;     // of a contact, in multiples of what resists it in its vertices alone
constexpr double kOwnFirmness = 20;  // of one between layers, where firmer ones take more iterations
constexpr double kWrong = 0.01;      // of all friction, that a step may have too much or too little
constexpr Real kGive = Real(0.02);   // of the thickness, that a closed contact may give way in a step

/// Σ of weights times a field.
Vec3 weighted(const Contact& c, const Vectors& field) {
  Vec3 sum;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) sum += field[std::size_t(c.vertex[k])] * c.weight[k];
  return sum;
}

/// Symmetric: xx yy zz xy xz yz.
Vec3d times(const std::array<double, 6>& m, Vec3d a) {
  return {m[0] * a.x + m[3] * a.y + m[4] * a.z, m[3] * a.x + m[1] * a.y + m[5] * a.z,
          m[4] * a.x + m[5] * a.y + m[2] * a.z};
}

/// The inverse of M + k n nᵀ, from that of M [Sherman, Morrison].
void stiffen(std::array<double, 6>& inverse, Vec3d n, double k) {
  const Vec3d a = times(inverse, n);
  const double s = k / (1 + k * dot(a, n));
  inverse[0] -= s * a.x * a.x, inverse[1] -= s * a.y * a.y, inverse[2] -= s * a.z * a.z;
  inverse[3] -= s * a.x * a.y, inverse[4] -= s * a.x * a.z, inverse[5] -= s * a.y * a.z;
}

std::array<double, 6> diagonal_inverse(const System& system, std::size_t v) {
  const Vec3d d(system.inverse[0][v]), o(system.inverse[1][v]);
  return {d.x, d.y, d.z, o.x, o.y, o.z};
}

/// Normal velocity that uses up the room of a contact in the step.
Real least_speed(const Contact& c, const ImplicitContact& a, double dt) {
  return dot(c.drift, c.normal) + a.out - std::max(c.room, Real(0)) / Real(dt);
}

Vec3 across(const Contact& c, Vec3 u) { return u - c.drift - c.normal * dot(u - c.drift, c.normal); }

/// What rubs while it slides is as large as Coulomb says at the speed it slides with, and falls with it
/// [lagged diffusivity: Kačanov]; what sticks begins with what it had. `u` is the latest known velocity.
void set_answer(const Contact& c, const State& state, double dt, bool is_closed, bool slips, Vec3 u,
                ImplicitContact& a) {
  a.normal_stiffness = a.tangential_stiffness = 0, a.load = {};
  if (!is_closed) return;
  const Vec3 aside = across(c, u);
  const Real limit = c.friction * c.impulse, speed = norm(aside);
  const bool moves = a.stick * speed > limit;
  a.normal_stiffness = a.stiff, a.held = moves ? Vec3{} : c.friction_impulse;
  a.tangential_stiffness = limit == 0                                     ? 0
                           : moves                                        ? limit / speed
                           : slips && dot(aside, c.friction_impulse) <= 0 ? 0
                                                                          : a.stick;
  const Vec3 before = weighted(c, state.v);
  a.load = c.normal * (c.impulse + a.normal_stiffness * (least_speed(c, a, dt) - dot(before, c.normal))) +
           a.held - across(c, before) * a.tangential_stiffness;
}

/// Diagonal blocks with what contacts add to them.
void stiffen_diagonal(State& state) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  for (std::size_t n = 0; n < contacts.touched.size(); n++) {
    const auto v = std::size_t(contacts.touched[n]);
    if (state.free_mass[v] == 0) continue;
    std::array<double, 6> inverse = state.implicit_contacts.inverse[n];
    for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
      const auto item = std::size_t(contacts.item[std::size_t(m)]);
      const Contact& c = contacts.list[item / 4];
      const ImplicitContact& a = state.implicit_contacts.answer[item / 4];
      const double w = double(c.weight[item % 4]);
      const Vec3d normal(c.normal);
      if (a.normal_stiffness > 0) stiffen(inverse, normal, w * w * double(a.normal_stiffness));
      if (!(a.tangential_stiffness > 0)) continue;
      const Vec3d aside = std::abs(normal.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
      const Vec3d t = normalized(cross(normal, aside));
      for (const Vec3d aside_too : {t, cross(normal, t)})
        stiffen(inverse, aside_too, w * w * double(a.tangential_stiffness));
    }
    state.system.inverse[0].set(v, Vec3(Vec3d{inverse[0], inverse[1], inverse[2]}));
    state.system.inverse[1].set(v, Vec3(Vec3d{inverse[3], inverse[4], inverse[5]}));
  }
}

/// What a contact's vertices alone have against its normal, by their blocks on the diagonal [kg]. Of layers
/// of the cloth every vertex is split among its contacts, so that together these are no firmer than one.
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

/// Does an obstacle press the cloth there, or will it?
bool presses(const Contact& c, const State& state, double dt) {
  return c.obstacle >= 0 && (c.impulse > 0 || dot(weighted(c, state.v), c.normal) < least_speed(c, {}, dt));
}

/// Which vertices are pressed by several obstacles.
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

/// Contacts with an obstacle, and those of them where another one presses as well.
struct Pressing {
  int all = 0, in_impact_zone = 0;
};

/// A cloth between a tool and a body cannot be freed by moving it: what is too near shows that their forces
/// lack something. The body gives way to these a frame later; by a stiffness beyond its own it would be
/// thrown away and come back.
void soften_squeezed(const Inputs& inputs, double dt, State& state) {
  constexpr Real kLedOut = Real(0.25);  // of what is too near, in a step
  std::vector<Contact>& list = state.implicit_contacts.contacts.list;
  const std::vector<char> squeezed = squeezed_vertices(state, dt);
  const auto is_caught = [&squeezed](const Contact& c) {
    return std::any_of(c.vertex.begin(), c.vertex.end(),
                       [&](int v) { return v >= 0 && squeezed[std::size_t(v)] != 0; });
  };
  std::vector<Pressing> pressing(inputs.obstacles.size());
  for (const Contact& c : list)
    if (presses(c, state, dt)) {
      Pressing& counts = pressing[std::size_t(c.obstacle)];
      counts.all++, counts.in_impact_zone += is_caught(c);
    }
  bool any_yields = false;
  for (std::size_t o = 0; o < pressing.size(); o++)
    any_yields = any_yields || (pressing[o].in_impact_zone > 0 && inputs.obstacles[o].compliance > 0);
  for (std::size_t n = 0; n < list.size() && any_yields; n++) {
    Contact& c = list[n];
    ImplicitContact& a = state.implicit_contacts.answer[n];
    if (c.obstacle < 0 || !(a.stiff > 0)) continue;
    const auto [all, in_impact_zone] = pressing[std::size_t(c.obstacle)];
    const double yields = inputs.obstacles[std::size_t(c.obstacle)].compliance / (dt * dt);
    const bool gives_way = is_caught(c);
    if (gives_way) a.out = kLedOut * std::max(-c.room, Real(0)) / Real(dt);
    if (in_impact_zone == 0 || yields == 0) continue;
    a.stick = Real(1 / (1 / double(a.stick) + yields * all));
    a.stiff = Real(1 / (1 / double(a.stiff) + yields * (gives_way ? in_impact_zone : all)));
    if (gives_way) c.plane = std::numeric_limits<Real>::lowest();  // its places are left to the body
  }
}

}  // namespace

void find_implicit_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                            double dt) {
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  find_step_contacts(exec, model, state, inputs, Look::kPredicted, dt, implicit_contacts.contacts.found);
  std::vector<Contact>& list = implicit_contacts.contacts.list;
  list.clear();
  for (const auto& found : implicit_contacts.contacts.found)
    list.insert(list.end(), found.begin(), found.end());
  link_contacts(model, state, implicit_contacts.contacts);
  implicit_contacts.answer.assign(list.size(), {});
  implicit_contacts.inverse.clear();
  for (const int v : implicit_contacts.contacts.touched)
    implicit_contacts.inverse.push_back(diagonal_inverse(state.system, std::size_t(v)));
  for (std::size_t n = 0; n < list.size(); n++)
    implicit_contacts.answer[n].stiff = implicit_contacts.answer[n].stick =
        Real((list[n].obstacle < 0 ? kOwnFirmness : kFirmness) * resistance(list[n], state));
  if (inputs.obstacles.size() > 1 && !list.empty()) soften_squeezed(inputs, dt, state);
  for (std::size_t n = 0; n < list.size(); n++) {
    Contact& c = list[n];
    ImplicitContact& answer = implicit_contacts.answer[n];
    c.is_implicit = true;
    const Vec3 u = weighted(c, state.v);
    const bool closes = dot(u, c.normal) < least_speed(c, answer, dt);
    const bool slips = norm(c.friction_impulse) >= Real(0.999) * c.friction * c.impulse;
    set_answer(c, state, dt, c.impulse > 0 || closes, slips, u, answer);
  }
  if (!list.empty()) stiffen_diagonal(state);
}

void stiffen_bearing(State& state) {
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  for (std::size_t n = 0; n < implicit_contacts.contacts.touched.size(); n++)
    implicit_contacts.inverse[n] =
        diagonal_inverse(state.system, std::size_t(implicit_contacts.contacts.touched[n]));
  stiffen_diagonal(state);
}

bool update_active_set(const Model& model, State& state, double dt) {
  ImplicitContacts& implicit_contacts = state.implicit_contacts;
  const Real give = kGive * Real(model.params.collision.thickness / dt);
  bool is_other = false;
  double wrong = 0, all = 0;  // friction [N·s]
  for (std::size_t n = 0; n < implicit_contacts.answer.size(); n++) {
    Contact& c = implicit_contacts.contacts.list[n];
    ImplicitContact& a = implicit_contacts.answer[n];
    const bool was_closed = a.normal_stiffness > 0;
    const Vec3 u = weighted(c, state.v) + weighted(c, state.system.change);
    const Real lack = least_speed(c, a, dt) - dot(u, c.normal);
    bool is_closed = lack > give, slips = false;
    if (was_closed) {
      c.impulse += a.normal_stiffness * lack;
      is_closed = c.impulse > 0;
      c.friction_impulse = a.held - across(c, u) * a.tangential_stiffness;
      const Real limit = c.friction * std::max(c.impulse, Real(0)), size = norm(c.friction_impulse);
      slips = size > Real(0.999) * limit;
      const bool moves = a.tangential_stiffness < a.stick;
      wrong += double(moves ? std::abs(size - limit) : std::max(Real(0), size - limit)), all += double(limit);
      if (size > limit) c.friction_impulse *= limit / size;
      is_other = is_other || lack > give;
    }
    if (!is_closed) c.impulse = 0, c.friction_impulse = {};
    is_other = is_other || is_closed != was_closed;
    set_answer(c, state, dt, is_closed, slips, u, a);
  }
  is_other = is_other || wrong > kWrong * all;
  if (is_other) stiffen_diagonal(state);
  return is_other;
}

Lanes3 implicit_contact_terms(const State& state, const Vectors& a, bool with_loads, std::size_t i) {
  const Contacts& contacts = state.implicit_contacts.contacts;
  Lanes3 sum{};
  const std::size_t end = std::min(i + std::size_t(kLanes), contacts.begin.size() - 1);
  for (std::size_t v = i; v < end; v++)
    for (int m = contacts.begin[v]; m < contacts.begin[v + 1]; m++) {
      const auto item = std::size_t(contacts.item[std::size_t(m)]);
      const Contact& c = contacts.list[item / 4];
      const ImplicitContact& answer = state.implicit_contacts.answer[item / 4];
      if (!(answer.normal_stiffness > 0)) continue;
      const Vec3 u = weighted(c, a);
      Vec3 impulse = -u * answer.tangential_stiffness -
                     c.normal * ((answer.normal_stiffness - answer.tangential_stiffness) * dot(u, c.normal));
      if (with_loads) impulse += answer.load;
      impulse *= c.weight[item % 4];
      const std::size_t l = v - i;
      sum.x[l] += impulse.x, sum.y[l] += impulse.y, sum.z[l] += impulse.z;
    }
  return sum;
}

}  // namespace turgor::cloth
