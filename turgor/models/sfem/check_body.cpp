#include "turgor/models/sfem/check_body.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/repeated_elements.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// Text such as "element 7 has" or "elements 3, 4, 9 and 12 more have" for error messages.
std::string named(const std::string& what, const std::vector<int>& ids) {
  constexpr std::size_t kShown = 5;
  std::string text = what + (ids.size() > 1 ? "s " : " ");
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); i++)
    text += (i == 0 ? "" : ", ") + std::to_string(ids[i]);
  if (ids.size() > kShown) text += " and " + std::to_string(ids.size() - kShown) + " more";
  return text;
}

Status check_arrays(const Body& body) {
  const SolidMesh& mesh = body.mesh;
  // element type
  const std::size_t vertices = mesh.vertices.size(), elements = element_count(mesh);
  if (mesh.corners != 4 && mesh.corners != 8 && mesh.corners != 10)
    return Error{"elements have 4, 8 or 10 nodes, found " + std::to_string(mesh.corners)};
  if (elements == 0) return Error{"the body has no element"};
  if (mesh.elements.size() % std::size_t(mesh.corners) != 0)
    return Error{std::to_string(mesh.elements.size()) + " corners do not make whole elements"};
  if (body.fixed.size() != vertices)
    return Error{"fixed: expected one number for each of " + std::to_string(vertices) + " vertices, found " +
                 std::to_string(body.fixed.size())};
  if (!body.material.empty() && body.material.size() != elements)
    return Error{"material: expected one number for each of " + std::to_string(elements) +
                 " elements, found " + std::to_string(body.material.size())};
  for (std::size_t e = 0; e < elements; e++)
    for (const int v : element(mesh, e))
      if (v < 0 || std::size_t(v) >= vertices)
        return Error{"element " + std::to_string(e) + " has vertex " + std::to_string(v) +
                     ", expected 0 to " + std::to_string(vertices - 1)};
  return Done{};
}

Status check_vertices(const SolidMesh& mesh) {
  std::vector<int> bad;
  for (const int v : mesh.elements) {
    const Vec3d x = mesh.vertices[std::size_t(v)];
    if (!is_finite(x)) bad.push_back(v);
  }
  sort_unique(bad);
  if (bad.empty()) return Done{};
  return Error{"coordinates must be finite numbers, not those of " + named("vertex number", bad)};
}

template <std::size_t N>
std::array<Vec3d, N> positions(const SolidMesh& mesh, std::size_t e) {
  std::array<Vec3d, N> x;
  for (std::size_t c = 0; c < N; c++) x[c] = mesh.vertices[std::size_t(element(mesh, e)[c])];
  return x;
}

double least_volume(const SolidMesh& mesh, std::size_t e) {
  if (mesh.corners == 8) return least_hex_volume(positions<8>(mesh, e));
  return mesh.corners == 4 ? volume(mesh, e) : least_quadratic_volume(positions<10>(mesh, e));
}

/// Volume of an element relative to its largest extent cubed. An element whose map may invert gives the
/// volume of its worst part. Not positive for an invalid element, near zero for a flat one.
double fullness(const SolidMesh& mesh, std::size_t e) {
  Vec3d low = mesh.vertices[std::size_t(element(mesh, e)[0])], high = low;
  for (const int v : element(mesh, e)) {
    const Vec3d x = mesh.vertices[std::size_t(v)];
    low = min(low, x), high = max(high, x);
  }
  const double least = least_volume(mesh, e);
  const double extent = norm(high - low);
  return extent > 0 ? least / (extent * extent * extent) : 0;
}

Status check_volumes(const SolidMesh& mesh) {
  constexpr double kFlat = 1e-10;  // below this, single entries of the stiffness would dominate all others
  std::vector<int> inverted, flat;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const double full = fullness(mesh, e);
    if (full < -kFlat)
      inverted.push_back(int(e));
    else if (full < kFlat)
      flat.push_back(int(e));
  }
  if (!inverted.empty())
    return Error{
        "an element's volume must be positive, but it is negative (the corners are in the wrong "
        "order, or folded over) in " +
        named("element", inverted)};
  if (!flat.empty())
    return Error{"an element must have a volume, but it is zero in " + named("element", flat)};
  return Done{};
}

Status check_repeated(const SolidMesh& mesh) {
  const std::vector<RepeatedElement> repeated = repeated_elements(mesh);
  if (repeated.empty()) return Done{};
  const auto [first, again] = repeated[0];
  return Error{"an element must be listed once, but " + std::to_string(repeated.size()) +
               " have the corners of another: the first is element " + std::to_string(again) +
               ", which repeats element " + std::to_string(first)};
}

Status check_materials(const Body& body) {
  // moduli
  const int count = int(body.materials.size());
  if (count == 0) return Error{"the body has no material"};
  for (int m = 0; m < count; m++) {
    const auto [young, poisson] = body.materials[std::size_t(m)];
    const std::string name = "material " + std::to_string(m);
    if (!(young > 0) || !std::isfinite(young))
      return Error{name + ": Young's modulus must be above 0 Pa, found " + number(young)};
    if (!(poisson > -1 && poisson < 0.5))
      return Error{name + ": Poisson's ratio must be above -1 and below 0.5, found " + number(poisson)};
  }
  // materials of elements and inclusions
  const auto in_range = [count](int m) { return m >= 0 && m < count; };
  std::vector<int> bad;
  for (std::size_t e = 0; e < body.material.size(); e++)
    if (!in_range(body.material[e])) bad.push_back(int(e));
  if (!bad.empty())
    return Error{"materials are 0 to " + std::to_string(count - 1) + ", found " +
                 std::to_string(body.material[std::size_t(bad[0])]) + " in " + named("element", bad)};
  for (std::size_t i = 0; i < body.inclusions.size(); i++)
    if (!in_range(body.inclusions[i].material))
      return Error{"inclusion " + std::to_string(i) + ": materials are 0 to " + std::to_string(count - 1) +
                   ", found " + std::to_string(body.inclusions[i].material)};
  return Done{};
}

Status check_inclusions(const Body& body) {
  for (std::size_t i = 0; i < body.inclusions.size(); i++) {
    const Inclusion& inclusion = body.inclusions[i];
    double nearest = INFINITY;
    for (std::size_t e = 0; e < element_count(body.mesh); e++)
      nearest = std::min(nearest, norm(centroid(body.mesh, e) - inclusion.center));
    if (!(nearest <= inclusion.radius))
      return Error{"inclusion " + std::to_string(i) + " holds no element: its radius is " +
                   number(inclusion.radius) + " m, the nearest centroid of an element is " + number(nearest) +
                   " m from its center"};
  }
  return Done{};
}

/// True when three points are not collinear: a corner's height is not tiny compared with the longest side.
bool span_a_plane(const std::vector<Vec3d>& points) {
  if (points.empty()) return false;
  const auto farther = [&points](auto distance) {
    return *std::max_element(points.begin(), points.end(),
                             [&](Vec3d p, Vec3d q) { return distance(p) < distance(q); });
  };
  const Vec3d a = points[0], b = farther([&](Vec3d p) { return norm(p - a); });
  const double length = norm(b - a);
  const auto height = [&](Vec3d p) { return norm(cross(p - a, b - a)); };
  return height(farther(height)) > 1e-6 * length * length;
}

/// Connected components of a body. A component is held by fixed vertices, or by vertices of held components.
struct Components {
  std::vector<std::vector<int>> vertices;  // of each component, ascending
  std::vector<std::uint8_t> is_held;
};

Components find_held_components(const Body& body) {
  Components components;
  const std::vector<int> component_of = connected_components(body.mesh);
  components.vertices.resize(std::size_t(*std::max_element(component_of.begin(), component_of.end())) + 1);
  for (std::size_t e = 0; e < component_of.size(); e++)
    for (const int v : element(body.mesh, e)) components.vertices[std::size_t(component_of[e])].push_back(v);
  for (std::vector<int>& vertices : components.vertices) {
    sort_unique(vertices);
  }
  components.is_held.assign(components.vertices.size(), 0);
  std::vector<std::uint8_t> still = body.fixed;  // vertices that cannot float away
  for (bool found = true; found;) {
    found = false;
    for (std::size_t p = 0; p < components.vertices.size(); p++) {
      if (components.is_held[p]) continue;
      std::vector<Vec3d> holds;
      for (const int v : components.vertices[p])
        if (still[std::size_t(v)]) holds.push_back(body.mesh.vertices[std::size_t(v)]);
      if (!span_a_plane(holds)) continue;
      components.is_held[p] = found = true;
      for (const int v : components.vertices[p]) still[std::size_t(v)] = 1;
    }
  }
  return components;
}

Status check_held(const Body& body) {
  // some fixed and some free vertices
  std::size_t used = 0, fixed = 0;
  std::vector<std::uint8_t> seen(body.fixed.size(), 0);
  for (const int v : body.mesh.elements)
    if (!seen[std::size_t(v)]) seen[std::size_t(v)] = 1, used++, fixed += body.fixed[std::size_t(v)] != 0;
  if (fixed == 0) return Error{"no vertex of the body is fixed: nothing holds it"};
  if (fixed == used) return Error{"all vertices of the body are fixed: nothing can move"};
  // components that are not held
  const Components components = find_held_components(body);
  const auto loose = std::find(components.is_held.begin(), components.is_held.end(), 0);
  if (loose == components.is_held.end()) return Done{};
  const std::size_t p = std::size_t(loose - components.is_held.begin());
  const auto count = std::count(components.is_held.begin(), components.is_held.end(), 0);
  // message
  std::vector<int> holds;
  for (const int v : components.vertices[p])
    if (body.fixed[std::size_t(v)]) holds.push_back(v);
  return Error{(count > 1 ? std::to_string(count) + " connected parts are" : "a connected part is") +
               " not held by three fixed vertices that are not on a line: the largest has " +
               std::to_string(components.vertices[p].size()) + " vertices, among them vertex " +
               std::to_string(components.vertices[p][0]) + "; " +
               (holds.empty() ? "none is fixed" : "fixed is only " + named("vertex number", holds))};
}

}  // namespace

Status check_body(const Body& body, bool may_be_loose) {
  if (const Status s = check_arrays(body); !s) return s;
  if (const Status s = check_vertices(body.mesh); !s) return s;
  if (const Status s = check_volumes(body.mesh); !s) return s;
  if (const Status s = check_repeated(body.mesh); !s) return s;
  if (const Status s = check_materials(body); !s) return s;
  if (const Status s = check_inclusions(body); !s) return s;
  return may_be_loose ? Status(Done{}) : check_held(body);
}

}  // namespace turgor::sfem
