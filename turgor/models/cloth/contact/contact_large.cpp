// Contacts of primitives that are large relative to the thickness, where a vertex could pass between the
// corners: vertex–triangle and edge–edge.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/contact/large_primitive_kernels.hpp"
#include "turgor/models/cloth/contact/neighborhood.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kChunkSize = 128;  // triangles or edges of a chunk
using NearPairs = std::vector<std::array<int, 2>>;

void resize(Neighborhood& near, std::size_t count) {
  for (Vectors* v : {&near.at, &near.rest, &near.edge, &near.rest_edge}) v->resize(padded(count));
}

/// Lists the sorted points in a box that pass `wanted`.
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

struct FindLargeContacts {
  const Model& model;
  const State& state;
  LargeView view;
  std::vector<char> is_sharp;  // of each large edge: others have no contacts

  Range around(const std::array<int, 2>& ends) const {
    return view.around(ends, state.contacts.longest_half);
  }

  /// Lists the vertices within reach of some triangles.
  void gather_near(std::span<const Int3> triangles, Neighborhood& near) const {
    TURGOR_CHECK(!triangles.empty(), "a block has triangles");
    Range box = view.around(triangles[0]);
    for (const Int3& t : triangles) box = joined(box, view.around(t));
    list_inside(
        state.spatial_hash, box, [](int) { return true; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++)
      near.at.set(n, view.at(near.index[n])), near.rest.set(n, view.at_rest(near.index[n]));
  }
  /// Lists the edges within reach of some edges; `first` is the first of these, and only later edges are
  /// listed.
  void gather_near(std::span<const std::array<int, 2>> edges, std::size_t first, Neighborhood& near) const {
    TURGOR_CHECK(!edges.empty(), "a block has edges");
    Range box = around(edges[0]);
    for (const std::array<int, 2>& e : edges) box = joined(box, around(e));
    list_inside(
        state.contacts.midpoint_hash, box,
        [&](int e) { return std::size_t(e) > first && is_sharp[std::size_t(e)]; }, near);
    resize(near, near.index.size());
    for (std::size_t n = 0; n < near.index.size(); n++) {
      const auto [a, b] = model.large.edges[std::size_t(near.index[n])];
      near.at.set(n, (view.at(a) + view.at(b)) * Real(0.5)), near.edge.set(n, view.at(b) - view.at(a));
      near.rest.set(n, (view.at_rest(a) + view.at_rest(b)) * Real(0.5));
      near.rest_edge.set(n, view.at_rest(b) - view.at_rest(a));
    }
  }

  /// Tests a triangle and a vertex.
  void test_triangle(int n, int v, std::vector<Contact>& found) const {
    const Int3 t = model.large.triangles[std::size_t(n)];
    Contact contact{.vertex = {v, t.x, t.y, t.z}};
    if (!is_implicit_already(state, contact, view.phase) && view.touch_triangle(std::size_t(n), v, contact))
      found.push_back(contact);
  }
  /// Tests two edges.
  void test_edges(int e, int other, std::vector<Contact>& found) const {
    const auto [a, b] = model.large.edges[std::size_t(e)];
    const auto [c, d] = model.large.edges[std::size_t(other)];
    Contact contact{.vertex = {a, b, c, d}};
    if (!is_implicit_already(state, contact, view.phase) &&
        view.touch_edges(std::size_t(e), std::size_t(other), contact))
      found.push_back(contact);
  }

  /// Lists the vertices that pass the filter of a triangle.
  void triangle(std::size_t n, const Neighborhood& near, NearPairs& pairs) const {
    visit_neighbors(near, view.filter(model.large.triangles[n]), [&](int v) {
      pairs.push_back({int(n), v});
    });
  }
  bool any_sharp(std::size_t first, std::size_t last) const {
    return std::find(is_sharp.begin() + std::ptrdiff_t(first), is_sharp.begin() + std::ptrdiff_t(last), 1) !=
           is_sharp.begin() + std::ptrdiff_t(last);
  }
  /// Marks the sharp edges.
  void measure_edges(const Exec& exec) {
    is_sharp.resize(model.large.edges.size());
    parallel_for(
        exec, is_sharp.size(), [&](std::size_t e) { is_sharp[e] = view.is_sharp(e); }, 1024);
  }
  /// Lists the pairs of triangles. Blocks of them have a common neighborhood.
  void triangles(std::size_t begin, std::size_t end, NearPairs& pairs) const {
    pairs.clear();
    Neighborhood near;
    for (std::size_t first = begin; first < end; first += kLargeBlock) {
      const std::size_t last = std::min(first + kLargeBlock, end);
      gather_near(std::span(model.large.triangles).subspan(first, last - first), near);
      for (std::size_t n = first; n < last; n++) triangle(n, near, pairs);
    }
  }
  /// Lists the later edges that pass the filter of an edge.
  void edge(std::size_t e, const Neighborhood& near, NearPairs& pairs) const {
    visit_neighbors(near, view.filter(model.large.edges[e], state.contacts.longest_half), [&](int other) {
      if (std::size_t(other) > e) pairs.push_back({int(e), other});
    });
  }
  /// Lists the pairs of edges.
  void edges(std::size_t begin, std::size_t end, NearPairs& pairs) const {
    pairs.clear();
    Neighborhood near;
    for (std::size_t first = begin; first < end; first += kLargeBlock) {
      const std::size_t last = std::min(first + kLargeBlock, end);
      if (!any_sharp(first, last)) continue;
      gather_near(std::span(model.large.edges).subspan(first, last - first), first, near);
      for (std::size_t e = first; e < last; e++)
        if (is_sharp[e]) edge(e, near, pairs);
    }
  }
};

/// Contact of a pair that CCD found in an earlier step; it is kept apart like large primitives while it is
/// near.
struct FindCcdContact {
  FindLargeContacts find;

  void operator()(const CcdPair& m, std::vector<Contact>& found) const {
    const auto [i, j, k, l] = m.vertex;
    const LargeView& view = find.view;
    Contact contact{.vertex = m.vertex};
    // weights of the nearest points
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
    if (view.make_contact(contact) && !is_implicit_already(find.state, contact, view.phase))
      found.push_back(contact);
  }
};

/// Midpoints of the large edges, sorted, and half of the longest edge.
void update_midpoints(const Exec& exec, const Model& model, State& state) {
  Contacts& contacts = state.contacts;
  const std::size_t count = model.large.edges.size();
  contacts.midpoints.resize(count + std::size_t(kLanes));
  Real longest2 = 0;
  for (std::size_t e = 0; e < count; e++) {
    const Vec3 a = state.x[std::size_t(model.large.edges[e][0])],
               b = state.x[std::size_t(model.large.edges[e][1])];
    contacts.midpoints.set(e, (a + b) * Real(0.5));
    longest2 = std::max(longest2, dot(b - a, b - a));
  }
  contacts.longest_half = std::sqrt(longest2) / 2;
  sort_points(exec, contacts.midpoints, int(count), model.large.longest, contacts.midpoint_hash);
}

}  // namespace

LargeView large_view(const Model& model, const State& state, ContactPhase phase, Real reach, double dt) {
  const LargePrimitives& large = model.large;
  return {{large.triangles.data(), large.across.data(), large.edges.data(), large.facing.data()},
          cones_view(model, state),
          view(state.x),
          view(state.v),
          view(state.system.change),
          view(model.x_rest),
          view(state.contacts),
          Real(model.params.collision.thickness),
          Real(model.params.collision.friction),
          reach,
          Real(dt),
          phase};
}

std::size_t large_chunks(const Model& model) {
  return (model.large.triangles.size() + kChunkSize - 1) / kChunkSize +
         (model.large.edges.size() + kChunkSize - 1) / kChunkSize;
}

void find_ccd_contacts(const Model& model, State& state, ContactPhase phase, double dt,
                       std::vector<Contact>& found) {
  TURGOR_CHECK(state.x.size() == model.mass.size(), "positions are on the host");
  const Real reach = Real(model.params.collision.thickness);
  const FindCcdContact find{{model, state, large_view(model, state, phase, reach, dt), {}}};
  // pairs of the latest step join those of earlier ones
  std::vector<CcdPair>& pairs = state.ccd.recent_pairs;
  pairs.insert(pairs.end(), state.ccd.ccd_pairs.begin(), state.ccd.ccd_pairs.end());
  sort_unique(pairs);
  found.clear();
  // pairs that are no longer near are dropped
  std::erase_if(pairs, [&](const CcdPair& m) {
    const std::size_t before = found.size();
    find(m, found);
    return found.size() == before;
  });
}

void find_large_contacts(const Exec& exec, const Model& model, State& state, ContactPhase phase, Real reach,
                         double dt, std::span<std::vector<Contact>> found) {
  TURGOR_CHECK(found.size() == large_chunks(model), "every chunk has a list of contacts");
  // midpoints of edges; the pairs of the predicted search are still near
  const bool is_listed = phase == ContactPhase::kActual && state.contacts.near_reach >= reach;
  if (!is_listed) update_midpoints(exec, model, state);
  FindLargeContacts find{model, state, large_view(model, state, phase, reach, dt), {}};
  if (!is_listed) find.measure_edges(exec);
  std::vector<NearPairs>& near_pairs = state.contacts.near_pairs;
  near_pairs.resize(found.size());
  const auto& triangles = model.large.triangles;
  const auto& edges = model.large.edges;
  const std::size_t triangle_chunks = (triangles.size() + kChunkSize - 1) / kChunkSize;
  // chunks of triangles, then of edges
  parallel_for(exec, found.size(), [&](std::size_t chunk) {
    const bool is_triangles = chunk < triangle_chunks;
    const std::size_t begin = (is_triangles ? chunk : chunk - triangle_chunks) * kChunkSize;
    const std::size_t end = std::min(begin + kChunkSize, is_triangles ? triangles.size() : edges.size());
    NearPairs& pairs = near_pairs[chunk];
    if (!is_listed) is_triangles ? find.triangles(begin, end, pairs) : find.edges(begin, end, pairs);
    found[chunk].clear();
    for (const auto [n, other] : pairs)
      is_triangles ? find.test_triangle(n, other, found[chunk]) : find.test_edges(n, other, found[chunk]);
  });
}

}  // namespace turgor::cloth
