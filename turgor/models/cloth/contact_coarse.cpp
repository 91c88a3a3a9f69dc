// Contacts of triangles that are large compared to the thickness, where a vertex could pass between the
// corners without coming near them: a vertex and a triangle, and two edges.
#include <algorithm>
#include <cmath>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/crossing.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kPieces = 128;  // triangles or edges that are done at once

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

/// Which of sixteen points are not beyond the sides of a triangle by more than the reach, and as near to its
/// plane.
struct NearPlanes {
  Vec3 through[4], normal[4];  // its own plane, then its sides'
  Real reach;

  unsigned operator()(Lanes3 p) const {
    unsigned bits = 0xffff;
    for (int k = 0; k < 4; k++) {
      const auto [n, o] = std::pair(normal[k], through[k]);
      const Lanes off = (p.x - o.x) * n.x + (p.y - o.y) * n.y + (p.z - o.z) * n.z;
      bits &= lanes_below(k == 0 ? larger(off, -off) : off, reach);
    }
    return bits;
  }
};

unsigned inside(Vec3 low, Vec3 high, Lanes3 p) {
  const Lanes x = larger(low.x - p.x, p.x - high.x), y = larger(low.y - p.y, p.y - high.y),
              z = larger(low.z - p.z, p.z - high.z);
  return lanes_below(larger(x, larger(y, z)), 0);
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
    const Real thickness = Real(model.params.collision.thickness);
    if (!(distance < reach) || !(distance > 0) || dot(at_rest, at_rest) < thickness * thickness) return;
    c.normal = d / distance;
    const Contact* old = find_old(state.contacts, c);
    if (old && dot(old->normal, c.normal) < 0) c.normal = -c.normal, distance = -distance;
    if (!is_wanted(state, c, old, look, side[0], side[1], distance, thickness, dt)) return;
    c.plane = thickness, c.room = distance - thickness;
    c.friction = Real(model.params.collision.friction);
    if (old) c.impulse = old->impulse * old->carry, c.rub = old->rub * old->carry;
    found.push_back(c);
  }

  void triangle(Int3 t, std::vector<Contact>& found) const {
    const Vec3 a = state.x[std::size_t(t.x)], b = state.x[std::size_t(t.y)], c = state.x[std::size_t(t.z)];
    const Vec3 margin{reach, reach, reach}, low = min(a, min(b, c)) - margin,
                                            high = max(a, max(b, c)) + margin;
    const Vec3 normal = normalized(cross(b - a, c - a));
    const NearPlanes planes{{a, a, b, c},
                            {normal, normalized(cross(b - a, normal)), normalized(cross(c - b, normal)),
                             normalized(cross(a - c, normal))},
                            reach};
    visit_box(
        state.near_points, low, high, [&](Lanes3 p) { return planes(p) & inside(low, high, p); },
        [&](int v, Vec3 p) {
          if (v == t.x || v == t.y || v == t.z) return;
          const TrianglePoint at = nearest_on_triangle(Vec3d(p), Vec3d(a), Vec3d(b), Vec3d(c));
          const Vec3 w(at.weights);
          if (at.distance >= double(reach) || w.x == 1 || w.y == 1 || w.z == 1) return;
          Contact contact{.vertex = {v, t.x, t.y, t.z}, .weight = {1, -w.x, -w.y, -w.z}};
          keep(contact, found);
        });
  }

  void edge(std::size_t e, std::vector<Contact>& found) const {
    const auto ends = model.coarse.edges[e];
    const int ea = ends[0], eb = ends[1];
    const Vec3 a = state.x[std::size_t(ea)], p = state.x[std::size_t(eb)] - a;
    const Real r = reach + state.contacts.longest_half;  // of a middle from this edge
    const Vec3 low = min(a, a + p) - Vec3{r, r, r}, high = max(a, a + p) + Vec3{r, r, r};
    const Real length2 = dot(p, p), inverse = length2 > 0 ? 1 / length2 : 0;
    const auto is_near = [&](Lanes3 q) {
      const Lanes3 d{q.x - a.x, q.y - a.y, q.z - a.z};
      const Lanes along =
          smaller(larger((d.x * p.x + d.y * p.y + d.z * p.z) * inverse, all_lanes(0)), all_lanes(1));
      const Lanes3 off{d.x - p.x * along, d.y - p.y * along, d.z - p.z * along};
      return lanes_below(dot(off, off), r * r);
    };
    visit_box(state.contacts.midpoints, low, high, is_near, [&](int other, Vec3) {
      if (std::size_t(other) <= e) return;
      const auto [fa, fb] = model.coarse.edges[std::size_t(other)];
      if (fa == ea || fa == eb || fb == ea || fb == eb) return;
      const Vec3 b = state.x[std::size_t(fa)], q = state.x[std::size_t(fb)] - b;
      Real s, t;
      if (!nearest_inside(a, p, b, q, s, t)) return;
      Contact contact{.vertex = {ea, eb, fa, fb}, .weight = {1 - s, s, t - 1, -t}};
      keep(contact, found);
    });
  }
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

/// Middles of the edges, and half of the longest.
void place_midpoints(const Exec& exec, const Model& model, State& state) {
  Contacts& contacts = state.contacts;
  const std::size_t count = model.coarse.edges.size();
  contacts.middles.resize(count);
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
    for (std::size_t i = begin; i < end; i++)
      is_triangles ? find.triangle(triangles[i], found[piece]) : find.edge(i, found[piece]);
  });
}

}  // namespace turgor::cloth
