// Contacts of triangles that are large compared to the thickness, where a vertex could pass between the
// corners without coming near them: a vertex and a triangle, and two edges.
#include <algorithm>
#include <cmath>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/large_primitive_kernels.hpp"
#include "turgor/models/cloth/contact/neighborhood.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kPieces = 128;  // triangles or edges that are done at once

void resize(Neighborhood& near, std::size_t count) {
  for (Vectors* v : {&near.at, &near.rest, &near.way, &near.rest_way}) v->resize(padded(count));
}

/// The sorted points in a box that are wanted, as they are sorted.
template <class Wanted>
void list_inside(const SpatialHash& points, const Range& box, const Wanted& wanted, Neighborhood& near) {
  near.index.clear();
  visit_box(
      points, box.low, box.high,
      [&](Lanes3 p, std::size_t) { return bits_inside<Lanes>(box.low, box.high, p); },
      [&](int point, Vec3) {
        if (wanted(point)) near.index.push_back(point);
      });
}

struct FindCoarse {
  const Model& model;
  const State& state;
  CoarseView view;

  void take(const Contact& c, std::vector<Contact>& found) const {
    if (!is_implicit_already(state, c, view.look)) found.push_back(c);
  }
  Range around(const std::array<int, 2>& ends) const {
    return view.around(ends, state.contacts.longest_half);
  }

  /// All vertices within reach of these triangles.
  void look_around(std::span<const Int3> triangles, Neighborhood& near) const {
    Range box = view.around(triangles[0]);
    for (const Int3& t : triangles) box = joined(box, view.around(t));
    list_inside(
        state.spatial_hash, box, [](int) { return true; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++)
      near.at.set(n, view.at(near.index[n])), near.rest.set(n, view.at_rest(near.index[n]));
  }
  /// All edges within reach of these, from `first` on, that come after it.
  void look_around(std::span<const std::array<int, 2>> edges, std::size_t first, Neighborhood& near) const {
    Range box = around(edges[0]);
    for (const std::array<int, 2>& e : edges) box = joined(box, around(e));
    list_inside(
        state.contacts.midpoints, box, [&](int e) { return std::size_t(e) > first; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++) {
      const auto [a, b] = model.coarse.edges[std::size_t(near.index[n])];
      near.at.set(n, (view.at(a) + view.at(b)) * Real(0.5)), near.way.set(n, view.at(b) - view.at(a));
      near.rest.set(n, (view.at_rest(a) + view.at_rest(b)) * Real(0.5));
      near.rest_way.set(n, view.at_rest(b) - view.at_rest(a));
    }
  }

  void triangle(Int3 t, const Neighborhood& near, std::vector<Contact>& found) const {
    visit_neighbors(near, view.sieve(t), [&](int v) {
      Contact contact;
      if (view.touch(t, v, contact)) take(contact, found);
    });
  }
  void edge(std::size_t e, const Neighborhood& near, std::vector<Contact>& found) const {
    const auto& edges = model.coarse.edges;
    visit_neighbors(near, view.sieve(edges[e], state.contacts.longest_half), [&](int other) {
      if (std::size_t(other) <= e) return;
      Contact contact;
      if (view.touch(edges[e], edges[std::size_t(other)], contact)) take(contact, found);
    });
  }
};

/// What would have met in the step before is kept apart like coarse triangles and edges, as long as it is
/// near.
struct FindMet {
  FindCoarse find;

  void operator()(const CcdPair& m, std::vector<Contact>& found) const {
    const auto [i, j, k, l] = m.vertex;
    const CoarseView& view = find.view;
    Contact contact{.vertex = m.vertex};
    if (m.are_edges) {
      Real s, t;
      const Vec3 a = view.at(i), b = view.at(k);
      if (!nearest_inside(a, view.at(j) - a, b, view.at(l) - b, s, t)) return;
      contact.weight = {1 - s, s, t - 1, -t};
    } else {
      const Vec3 w(
          nearest_on_triangle(Vec3d(view.at(i)), Vec3d(view.at(j)), Vec3d(view.at(k)), Vec3d(view.at(l)))
              .weights);
      contact.weight = {1, -w.x, -w.y, -w.z};
    }
    if (view.keep(contact)) find.take(contact, found);
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

CoarseView coarse_view(const Model& model, const State& state, Look look, Real reach, double dt) {
  return {view(state.x),
          view(state.v),
          view(state.system.change),
          view(model.x_rest),
          view(state.contacts),
          Real(model.params.collision.thickness),
          Real(model.params.collision.friction),
          reach,
          Real(dt),
          look};
}

std::size_t coarse_pieces(const Model& model) {
  return (model.coarse.triangles.size() + kPieces - 1) / kPieces +
         (model.coarse.edges.size() + kPieces - 1) / kPieces;
}

void find_met_contacts(const Model& model, State& state, Look look, double dt, std::vector<Contact>& found) {
  const Real reach = Real(model.params.collision.thickness);
  const FindMet find{{model, state, coarse_view(model, state, look, reach, dt)}};
  std::vector<CcdPair>& met = state.ccd.met;
  met.insert(met.end(), state.ccd.ccd_pairs.begin(), state.ccd.ccd_pairs.end());
  sort_unique(met);
  found.clear();
  std::erase_if(met, [&](const CcdPair& m) {
    const std::size_t before = found.size();
    find(m, found);
    return found.size() == before;
  });
}

void find_coarse_contacts(const Exec& exec, const Model& model, State& state, Look look, Real reach,
                          double dt, std::span<std::vector<Contact>> found) {
  place_midpoints(exec, model, state);
  const FindCoarse find{model, state, coarse_view(model, state, look, reach, dt)};
  const auto& triangles = model.coarse.triangles;
  const auto& edges = model.coarse.edges;
  const std::size_t triangle_pieces = (triangles.size() + kPieces - 1) / kPieces;
  parallel_for(exec, found.size(), [&](std::size_t piece) {
    found[piece].clear();
    const bool is_triangles = piece < triangle_pieces;
    const std::size_t begin = (is_triangles ? piece : piece - triangle_pieces) * kPieces;
    const std::size_t end = std::min(begin + kPieces, is_triangles ? triangles.size() : edges.size());
    Neighborhood near;
    for (std::size_t first = begin; first < end; first += kCoarseBlock) {
      const std::size_t last = std::min(first + kCoarseBlock, end);
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
