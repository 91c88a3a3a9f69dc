// Contacts of triangles that are large compared to the thickness, where a vertex could pass between the
// corners without coming near them: a vertex and a triangle, and two edges.
#include <algorithm>
#include <cmath>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/coarse_near.hpp"
#include "turgor/models/cloth/crossing.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kPieces = 128;  // triangles or edges that are done at once
constexpr std::size_t kBlock = 16;    // of these that have one neighbourhood

/// How far two places must be apart whose distance along the sheet is `along`: a sheet that turns round in
/// half a circle of its thickness θ has them θ sin(along/θ) apart. 0 = they are neighbours, nothing keeps
/// them.
Real least_distance(Real along, Real thickness) {
  constexpr Real kTurn = Real(1.5707963);  // from here on they may face each other
  const Real turns = along / thickness;
  return turns < 1 ? 0 : turns < kTurn ? thickness * std::sin(turns) : thickness;
}

/// Where two segments a + s·p and b + t·q, 0 ≤ s, t ≤ 1, are nearest inside of both; false when that is at an
/// end, where vertices are nearest.
bool nearest_inside(Vec3 a, Vec3 p, Vec3 b, Vec3 q, Real& s, Real& t) {
  const Vec3 d = b - a;
  const Real pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), dp = dot(d, p), dq = dot(d, q);
  const Real determinant = pp * qq - pq * pq;
  if (!(determinant > Real(1e-6) * pp * qq)) return false;
  s = (dp * qq - dq * pq) / determinant, t = (dp * pq - dq * pp) / determinant;
  return s > 0 && s < 1 && t > 0 && t < 1;
}

struct Box {
  Vec3 low, high;
};
Box both(const Box& a, const Box& b) { return {min(a.low, b.low), max(a.high, b.high)}; }

void resize(Neighbourhood& near, std::size_t count) {
  for (Vectors* v : {&near.at, &near.rest, &near.way, &near.rest_way}) v->resize(padded(count));
}

/// The sorted points in a box that are wanted, as they are sorted.
template <class Wanted>
void list_inside(const NearPoints& points, const Box& box, const Wanted& wanted, Neighbourhood& near) {
  near.index.clear();
  visit_box(
      points, box.low, box.high, [&](Lanes3 p, std::size_t) { return lanes_inside(box.low, box.high, p); },
      [&](int point, Vec3) {
        if (wanted(point)) near.index.push_back(point);
      });
}

struct FindCoarse {
  const Model& model;
  const State& state;
  Look look;
  Real reach, dt;

  /// Keeps the contact when it will be too near, or was; fills in what follows from vertices and weights.
  void keep(Contact& c, std::vector<Contact>& found) const {
    Vec3 d, at_rest;
    Group side[2];  // weights above and below 0
    for (std::size_t k = 0; k < 4; k++) {
      const auto v = std::size_t(c.vertex[k]);
      Group& mine = side[c.weight[k] < 0];
      const Real w = std::abs(c.weight[k]);
      d += state.x[v] * c.weight[k], at_rest += model.x_rest[v] * c.weight[k];
      mine.v += state.v[v] * w, mine.change += state.system.change[v] * w;
      mine.touches = mine.touches || state.contacts.touches(c.vertex[k]);
    }
    Real distance = norm(d);
    const Real along = norm(at_rest), least = least_distance(along, Real(model.params.collision.thickness));
    if (!(distance < reach) || !(distance > 0) || least == 0 || distance > kStraight * along) return;
    c.normal = d / distance;
    const Contact* old = find_old(state.contacts, c);
    if (old && dot(old->normal, c.normal) < 0) c.normal = -c.normal, distance = -distance;
    if (!is_wanted(c.normal, old, look, side[0], side[1], distance, least, dt)) return;
    if (is_borne_already(state, c, look)) return;
    c.plane = least, c.room = distance - least;
    c.friction = Real(model.params.collision.friction);
    if (old) c.impulse = old->impulse * old->carry, c.rub = old->rub * old->carry;
    found.push_back(c);
  }

  Box around(const Int3& t) const {
    const Vec3 a = at(t.x), b = at(t.y), c = at(t.z), margin{reach, reach, reach};
    return {min(a, min(b, c)) - margin, max(a, max(b, c)) + margin};
  }
  /// Of the middles of edges that are near to this one.
  Box around(const std::array<int, 2>& ends) const {
    const Vec3 a = at(ends[0]), b = at(ends[1]);
    const Real r = Real(1.01) * (reach + state.contacts.longest_half);
    return {min(a, b) - Vec3{r, r, r}, max(a, b) + Vec3{r, r, r}};
  }

  /// All vertices within reach of these triangles.
  void look_around(std::span<const Int3> triangles, Neighbourhood& near) const {
    Box box = around(triangles[0]);
    for (const Int3& t : triangles) box = both(box, around(t));
    list_inside(
        state.near_points, box, [](int) { return true; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++)
      near.at.set(n, at(near.index[n])), near.rest.set(n, at_rest(near.index[n]));
  }
  /// All edges within reach of these, from `first` on, that come after it.
  void look_around(std::span<const std::array<int, 2>> edges, std::size_t first, Neighbourhood& near) const {
    Box box = around(edges[0]);
    for (const std::array<int, 2>& e : edges) box = both(box, around(e));
    list_inside(
        state.contacts.midpoints, box, [&](int e) { return std::size_t(e) > first; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++) {
      const auto [a, b] = model.coarse.edges[std::size_t(near.index[n])];
      near.at.set(n, (at(a) + at(b)) * Real(0.5)), near.way.set(n, at(b) - at(a));
      near.rest.set(n, (at_rest(a) + at_rest(b)) * Real(0.5)), near.rest_way.set(n, at_rest(b) - at_rest(a));
    }
  }

  void triangle(Int3 t, const Neighbourhood& near, std::vector<Contact>& found) const {
    const Vec3 a = at(t.x), b = at(t.y), c = at(t.z);
    const Box box = around(t);
    const NearTriangle is_near{nearness(),
                               box.low,
                               box.high,
                               {a, b - a, c - a},
                               {at_rest(t.x), at_rest(t.y) - at_rest(t.x), at_rest(t.z) - at_rest(t.x)}};
    visit_neighbours(near, is_near, [&](int v) {
      if (v == t.x || v == t.y || v == t.z) return;
      const TrianglePoint nearest = nearest_on_triangle(Vec3d(at(v)), Vec3d(a), Vec3d(b), Vec3d(c));
      const Vec3 w(nearest.weights);
      if (nearest.distance >= double(reach) || w.x == 1 || w.y == 1 || w.z == 1) return;
      Contact contact{.vertex = {v, t.x, t.y, t.z}, .weight = {1, -w.x, -w.y, -w.z}};
      keep(contact, found);
    });
  }

  void edge(std::size_t e, const Neighbourhood& near, std::vector<Contact>& found) const {
    const auto ends = model.coarse.edges[e];
    const int ea = ends[0], eb = ends[1];
    const Vec3 a = at(ea), p = at(eb) - a;
    const Box box = around(ends);
    const NearEdge is_near{nearness(), box.low, box.high, {a, p}, {at_rest(ea), at_rest(eb) - at_rest(ea)}};
    visit_neighbours(near, is_near, [&](int other) {
      if (std::size_t(other) <= e) return;
      const auto [fa, fb] = model.coarse.edges[std::size_t(other)];
      if (fa == ea || fa == eb || fb == ea || fb == eb) return;
      const Vec3 b = at(fa), q = at(fb) - b;
      Real s, t;
      if (!nearest_inside(a, p, b, q, s, t)) return;
      Contact contact{.vertex = {ea, eb, fa, fb}, .weight = {1 - s, s, t - 1, -t}};
      keep(contact, found);
    });
  }

  Vec3 at(int v) const { return state.x[std::size_t(v)]; }
  Vec3 at_rest(int v) const { return model.x_rest[std::size_t(v)]; }
  Nearness nearness() const { return {reach, Real(model.params.collision.thickness)}; }
};

/// What would have met in the step before is kept apart like coarse triangles and edges, as long as it is
/// near.
struct FindMet {
  FindCoarse find;

  void operator()(const Meeting& m, std::vector<Contact>& found) const {
    const auto [i, j, k, l] = m.vertex;
    const auto at = [&](int v) { return find.state.x[std::size_t(v)]; };
    Contact contact{.vertex = m.vertex};
    if (m.are_edges) {
      Real s, t;
      if (!nearest_inside(at(i), at(j) - at(i), at(k), at(l) - at(k), s, t)) return;
      contact.weight = {1 - s, s, t - 1, -t};
    } else {
      const Vec3 w(nearest_on_triangle(Vec3d(at(i)), Vec3d(at(j)), Vec3d(at(k)), Vec3d(at(l))).weights);
      contact.weight = {1, -w.x, -w.y, -w.z};
    }
    find.keep(contact, found);
  }
};

/// Middles of the edges, sorted, and half of the longest.
void place_midpoints(const Exec& exec, const Model& model, State& state) {
  Contacts& contacts = state.contacts;
  const std::size_t count = model.coarse.edges.size();
  contacts.middles.resize(count + std::size_t(kLanes));
  Real longest2 = 0;
  for (std::size_t e = 0; e < count; e++) {
    const Vec3 a = state.x[std::size_t(model.coarse.edges[e][0])],
               b = state.x[std::size_t(model.coarse.edges[e][1])];
    contacts.middles.set(e, (a + b) * Real(0.5));
    longest2 = std::max(longest2, dot(b - a, b - a));
  }
  contacts.longest_half = std::sqrt(longest2) / 2;
  sort_points(exec, contacts.middles, int(count), model.coarse.longest, contacts.midpoints);
}

}  // namespace

std::size_t coarse_pieces(const Model& model) {
  return (model.coarse.triangles.size() + kPieces - 1) / kPieces +
         (model.coarse.edges.size() + kPieces - 1) / kPieces;
}

void find_met_contacts(const Model& model, State& state, Look look, double dt, std::vector<Contact>& found) {
  const FindMet find{{model, state, look, Real(model.params.collision.thickness), Real(dt)}};
  std::vector<Meeting>& met = state.crossing.met;
  met.insert(met.end(), state.crossing.meetings.begin(), state.crossing.meetings.end());
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  found.clear();
  std::erase_if(met, [&](const Meeting& m) {
    const std::size_t before = found.size();
    find(m, found);
    return found.size() == before;
  });
}

void find_coarse_contacts(const Exec& exec, const Model& model, State& state, Look look, Real reach,
                          double dt, std::span<std::vector<Contact>> found) {
  place_midpoints(exec, model, state);
  const FindCoarse find{model, state, look, reach, Real(dt)};
  const auto& triangles = model.coarse.triangles;
  const auto& edges = model.coarse.edges;
  const std::size_t triangle_pieces = (triangles.size() + kPieces - 1) / kPieces;
  parallel_for(exec, found.size(), [&](std::size_t piece) {
    found[piece].clear();
    const bool is_triangles = piece < triangle_pieces;
    const std::size_t begin = (is_triangles ? piece : piece - triangle_pieces) * kPieces;
    const std::size_t end = std::min(begin + kPieces, is_triangles ? triangles.size() : edges.size());
    Neighbourhood near;
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t last = std::min(first + kBlock, end);
      if (is_triangles)
        find.look_around(std::span(triangles).subspan(first, last - first), near);
      else
        find.look_around(std::span(edges).subspan(first, last - first), first, near);
      for (std::size_t i = first; i < last; i++)
        is_triangles ? find.triangle(triangles[i], near, found[piece]) : find.edge(i, near, found[piece]);
    }
  });
}

}  // namespace turgor::cloth
