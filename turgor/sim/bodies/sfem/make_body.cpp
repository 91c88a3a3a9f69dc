#include "turgor/sim/bodies/sfem/make_body.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/body_location.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor {

namespace {

Vec3d in_box(const Box& box, Vec3d fraction) { return box.low + hadamard(fraction, box.high - box.low); }

/// True if a point is in a box, or outside of it by no more than a slack for rounding.
bool is_inside(const Box& box, Vec3d x, Vec3d slack) {
  for (int axis = 0; axis < 3; axis++)
    if (x[axis] < box.low[axis] - slack[axis] || x[axis] > box.high[axis] + slack[axis]) return false;
  return true;
}

/// Slab of a box near one of its sides.
Box near_side(Box box, Side side, double depth) {
  TURGOR_CHECK(is_index(int(side), 6), "a box has six sides");
  const int axis = int(side) / 2;
  const bool high = int(side) % 2 == 1;
  const double extent = box.high[axis] - box.low[axis], reach = extent * depth;
  if (high)
    box.low[axis] = box.high[axis] - reach;
  else
    box.high[axis] = box.low[axis] + reach;
  return box;
}

/// Box that holds the body, in meters.
Box holding_box(const Box& body, const HeldBy& held) {
  TURGOR_ASSERT(held.box.has_value(), "the body is held in a box");
  const auto& [low, high] = *held.box;
  return held.by_fraction ? Box{in_box(body, low), in_box(body, high)} : Box{low, high};
}

bool holds_an_element(const SolidMesh& mesh, const sfem::Inclusion& inclusion) {
  for (std::size_t e = 0; e < element_count(mesh); e++)
    if (norm(centroid(mesh, e) - inclusion.center) <= inclusion.radius) return true;
  return false;
}

Status add_inside(const SfemScene& scene, sfem::Body& body) {
  if (scene.inside.empty()) return Done{};
  // start with the base material
  const std::set<int> labels(body.mesh.regions.begin(), body.mesh.regions.end());
  body.material.assign(element_count(body.mesh), 0);
  for (const InsideScene& inside : scene.inside) {
    // check the label
    if (!labels.contains(inside.label))
      return Error{fmt::format(
          "{}.inside.{}: no element has the label {}; known labels: {}", scene.source_location, inside.name,
          inside.label, labels.empty() ? std::string("none") : fmt::format("{}", fmt::join(labels, ", ")))};
    // assign the material to elements of that label
    const int index = int(body.materials.size());
    body.materials.push_back(inside.material);
    for (std::size_t e = 0; e < body.material.size(); e++)
      if (region(body.mesh, e) == inside.label) body.material[e] = index;
  }
  return Done{};
}

Status add_inclusions(const SfemScene& scene, sfem::Body& body) {
  const Box box = box_around(body.mesh.vertices);
  for (const InclusionScene& given : scene.inclusions) {
    // sphere in body coordinates
    const sfem::Inclusion inclusion{.center = given.by_fraction ? in_box(box, given.center) : given.center,
                                    .radius = given.radius,
                                    .material = int(body.materials.size())};
    // check that the sphere contains an element
    if (!holds_an_element(body.mesh, inclusion))
      return Error{fmt::format(
          "{}.inclusion.{}: no element has its center in the sphere around {:.4g}, {:.4g}, {:.4g} m with the "
          "radius {} m; expected a position inside the body and a radius above half of an element; {}",
          scene.source_location, given.name, inclusion.center.x, inclusion.center.y, inclusion.center.z,
          given.radius, describe_location(body.mesh.vertices, inclusion.center))};
    // add sphere and material
    body.materials.push_back(given.material);
    body.inclusions.push_back(inclusion);
  }
  return Done{};
}

/// Number of corner vertices; in quadratic elements they come before the edge midpoints.
std::size_t corner_count(const SolidMesh& mesh) {
  return mesh.corners == 10 ? without_middles(mesh).vertices.size() : mesh.vertices.size();
}

}  // namespace

std::vector<std::uint8_t> held_points(std::span<const Vec3d> points, const HeldBy& held) {
  constexpr double kSlack = 1e-6;  // of the body's extent: layers of vertices have rounded coordinates
  const Box box = box_around(points);
  const Vec3d slack = (box.high - box.low) * kSlack;
  std::vector<Box> holders;
  if (held.box) {
    holders.push_back(holding_box(box, held));
  } else {
    for (const Side side : held.sides) holders.push_back(near_side(box, side, held.depth));
  }
  std::vector<std::uint8_t> fixed(points.size(), 0);
  for (std::size_t v = 0; v < fixed.size(); v++)
    fixed[v] = std::any_of(holders.begin(), holders.end(),
                           [&](const Box& holder) { return is_inside(holder, points[v], slack); });
  return fixed;
}

Status check_held(std::span<const Vec3d> points, const HeldBy& held, const std::vector<std::uint8_t>& fixed) {
  TURGOR_CHECK(fixed.size() == points.size(), "every point has a mark");
  const bool holds = std::any_of(fixed.begin(), fixed.end(), [](std::uint8_t is_fixed) { return is_fixed; });
  if (!held.box || holds || points.empty()) return Done{};
  const Box box = holding_box(box_around(points), held);
  return Error{fmt::format("fixed: the box from {} to {} contains no vertex of the body; {}",
                           position_text(box.low), position_text(box.high),
                           describe_location(points, (box.low + box.high) * 0.5))};
}

Result<sfem::Body> make_body(SolidMesh mesh, const SfemScene& scene) {
  const bool quadratic = scene.elements == Elements::kQuadratic && mesh.corners == 4;
  sfem::Body body;
  const std::span<const Vec3d> corners = std::span(mesh.vertices).first(corner_count(mesh));
  body.fixed = held_points(corners, scene.fixed);
  if (const Status held = check_held(corners, scene.fixed, body.fixed); !held)
    return Error{fmt::format("{}: {}", scene.source_location, held.error().message)};
  body.mesh = std::move(mesh);
  if (body.mesh.corners == 10) sfem::fix_middles(body);
  body.materials = {scene.material};
  if (const Status status = add_inside(scene, body); !status) return status.error();
  if (const Status status = add_inclusions(scene, body); !status) return status.error();
  return quadratic ? sfem::with_middles(std::move(body)) : body;
}

}  // namespace turgor
