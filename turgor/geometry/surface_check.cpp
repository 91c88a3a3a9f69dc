#include "turgor/geometry/surface_check.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/signed_distance.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/geometry/weld.hpp"

namespace turgor {

namespace {

constexpr std::size_t kExamples = 3;  // listed in an error

std::string position_text(Vec3d p) {
  return number_text(p.x * 1e3) + " " + number_text(p.y * 1e3) + " " + number_text(p.z * 1e3) + " mm";
}

/// " (vertices, counted from 0: 3-7 at 10 0 -5 mm; …)".
std::string examples(const TriMesh& surface, const std::vector<EdgeUse>& edges) {
  const auto position = [&](int v) { return Vec3d(surface.vertices[std::size_t(v)]); };
  std::string text = " (vertices, counted from 0: ";
  for (std::size_t i = 0; i < std::min(edges.size(), kExamples); i++) {
    const EdgeUse& edge = edges[i];
    text += (i ? "; " : "") + std::to_string(edge.a) + "-" + std::to_string(edge.b) + " at " +
            position_text((position(edge.a) + position(edge.b)) / 2);
  }
  return text + (edges.size() > kExamples ? "; …)" : ")");
}

/// "3 edges are", "1 edge is".
std::string edges_are(const std::vector<EdgeUse>& edges) {
  return std::to_string(edges.size()) + (edges.size() == 1 ? " edge is" : " edges are");
}

Status check_edges(const TriMesh& surface) {
  std::vector<EdgeUse> open, crowded, disagreeing;
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const EdgeUse> uses) {
    if (uses.size() == 1) open.push_back(uses[0]);
    if (uses.size() > 2) crowded.push_back(uses[0]);
    if (uses.size() == 2 && uses[0].forward == uses[1].forward) disagreeing.push_back(uses[0]);
  });
  if (!open.empty())
    return Error{"the surface is open: " + edges_are(open) + " of one triangle only" +
                 examples(surface, open) + "; expected a closed surface, fill its holes first"};
  if (!crowded.empty())
    return Error{"the surface is not a manifold: " + edges_are(crowded) + " of more than two triangles" +
                 examples(surface, crowded) + "; expected two at every edge"};
  if (!disagreeing.empty())
    return Error{"neighboring triangles have opposite orientations: " + edges_are(disagreeing) +
                 " traversed in the same direction by both triangles" + examples(surface, disagreeing) +
                 "; orient them consistently first"};
  return Done{};
}

double enclosed_volume(const TriMesh& surface, const std::vector<Int3>& triangles) {
  // relative to a vertex of the surface, so that a distant origin costs no precision
  const auto x = [&](int v) { return Vec3d(surface.vertices[std::size_t(v)]); };
  double sum = 0;
  for (const auto [a, b, c] : triangles) sum += orientation(x(triangles[0].x), x(a), x(b), x(c)) / 6;
  return sum;
}

/// Triangles by component, connected by their edges.
std::vector<std::vector<Int3>> connected_triangles(const TriMesh& surface) {
  std::vector<int> parent(surface.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const EdgeUse> uses) {
    join_sets(parent, uses[0].triangle, uses[1].triangle);
  });
  std::map<int, std::vector<Int3>> components;
  for (std::size_t t = 0; t < parent.size(); t++)
    components[root_of(parent, int(t))].push_back(surface.triangles[t]);
  std::vector<std::vector<Int3>> result;
  for (auto& [first, component] : components) result.push_back(std::move(component));
  return result;
}

void turn_round(std::vector<Int3>& triangles) {
  for (Int3& t : triangles) std::swap(t.y, t.z);
}

/// Largest component with its cavities; all others are dropped.
CheckedSurface largest_body(const TriMesh& surface) {
  std::vector<std::vector<Int3>> components = connected_triangles(surface);
  std::vector<double> volumes;
  for (const auto& component : components) volumes.push_back(enclosed_volume(surface, component));
  // component with the largest volume, oriented outward
  const std::size_t body =
      std::size_t(std::max_element(volumes.begin(), volumes.end(),
                                   [](double a, double b) { return std::abs(a) < std::abs(b); }) -
                  volumes.begin());
  CheckedSurface result;
  if (volumes[body] < 0) {
    for (std::size_t i = 0; i < components.size(); i++) turn_round(components[i]), volumes[i] = -volumes[i];
    result.notes.emplace_back("the surface was inside out; its triangles were reversed");
  }
  result.mesh = {.vertices = surface.vertices, .triangles = components[body]};
  result.volume = volumes[body];
  if (components.size() == 1) return result;
  // inverted components inside it are cavities, all others are dropped
  const SignedDistance outer = distance_to_surface(result.mesh);
  std::size_t left_out = 0;
  double left_volume = 0;
  for (std::size_t i = 0; i < components.size(); i++) {
    if (i == body) continue;
    const bool cavity =
        volumes[i] < 0 && outer.at(Vec3d(surface.vertices[std::size_t(components[i][0].x)])) < 0;
    if (!cavity) left_out++, left_volume += std::abs(volumes[i]);
    if (!cavity) continue;
    result.mesh.triangles.insert(result.mesh.triangles.end(), components[i].begin(), components[i].end());
    result.volume += volumes[i];
  }
  if (left_out > 0)
    result.notes.push_back(std::to_string(left_out) +
                           (left_out == 1 ? " smaller component" : " smaller components") +
                           " of the surface with " + number_text(left_volume * 1e6) +
                           " mL ignored: a body is made of the largest component");
  return result;
}

/// "the surface crosses itself: 12 pairs of triangles, the first at 1 2 3 mm".
std::string crossings_text(const TriMesh& surface, const std::vector<std::pair<int, int>>& pairs) {
  const int vertex = surface.triangles[std::size_t(pairs[0].first)].x;
  return "the surface crosses itself: " + std::to_string(pairs.size()) +
         (pairs.size() == 1 ? " pair" : " pairs") + " of triangles, the first at " +
         position_text(Vec3d(surface.vertices[std::size_t(vertex)]));
}

void note_crossings(const Exec& exec, CheckedSurface& body) {
  const auto pairs = crossing_triangles(exec, body.mesh);
  body.crossings = pairs.size();
  if (pairs.empty()) return;
  body.notes.push_back(crossings_text(body.mesh, pairs) + "; the inside is defined by the winding number");
}

/// Components with a positive volume whose first vertex is inside another such component.
struct Nested {
  std::size_t count = 0;
  double volume = 0;  // [m³]
};

Nested nested_components(const TriMesh& surface) {
  // bodies without their cavities
  std::vector<std::vector<Int3>> bodies;
  for (std::vector<Int3>& component : connected_triangles(surface))
    if (enclosed_volume(surface, component) > 0) bodies.push_back(std::move(component));
  if (bodies.size() < 2) return {};
  // those inside another one
  std::vector<char> is_nested(bodies.size(), 0);
  for (std::size_t i = 0; i < bodies.size(); i++) {
    // those whose first vertex is in its box, which are few
    std::vector<Vec3d> corners;
    for (const Int3 t : bodies[i])
      for (int k = 0; k < 3; k++) corners.push_back(Vec3d(surface.vertices[std::size_t(t[k])]));
    const Box box = box_around(corners);
    std::vector<std::size_t> near;
    const auto first = [&](std::size_t j) { return Vec3d(surface.vertices[std::size_t(bodies[j][0].x)]); };
    for (std::size_t j = 0; j < bodies.size(); j++)
      if (j != i && squared_distance(box, first(j)) == 0) near.push_back(j);
    if (near.empty()) continue;
    const SignedDistance outer = distance_to_surface({.vertices = surface.vertices, .triangles = bodies[i]});
    for (const std::size_t j : near)
      if (outer.at(first(j)) < 0) is_nested[j] = 1;
  }
  Nested nested;
  for (std::size_t j = 0; j < bodies.size(); j++)
    if (is_nested[j]) nested.count++, nested.volume += enclosed_volume(surface, bodies[j]);
  return nested;
}

}  // namespace

Result<CheckedSurface> check_surface(const Exec& exec, const TriMesh& surface) {
  if (surface.triangles.empty()) return Error{"the surface has no triangles"};
  for (std::size_t v = 0; v < surface.vertices.size(); v++)
    if (const Vec3 p = surface.vertices[v]; !is_finite(p))
      return Error{"vertex " + std::to_string(v) + " (counted from 0) has a coordinate that is not a number"};
  const TriMesh whole = welded(surface);
  if (whole.triangles.empty()) return Error{"all triangles of the surface are points or lines"};
  if (Status edges = check_edges(whole); !edges) return edges.error();
  CheckedSurface body = largest_body(whole);
  if (!(body.volume > 0)) return Error{"the surface encloses no volume"};
  note_crossings(exec, body);
  return body;
}

std::vector<std::string> overlap_notes(const Exec& exec, const TriMesh& surface) {
  std::vector<std::string> notes;
  const auto pairs = crossing_triangles(exec, surface);
  if (!pairs.empty())
    notes.push_back(crossings_text(surface, pairs) + "; tools also touch what lies inside the body there");
  const Nested nested = nested_components(surface);
  if (nested.count > 0)
    notes.push_back(std::to_string(nested.count) + (nested.count == 1 ? " component" : " components") +
                    " of the surface with " + number_text(nested.volume * 1e6) +
                    (nested.count == 1 ? " mL lies" : " mL lie") +
                    " inside another one: tools also touch what lies inside the body there");
  return notes;
}

}  // namespace turgor
