#include "turgor/models/lattice/cutting/skin_near.hpp"

#include <cmath>
#include <limits>

#include "turgor/geometry/body_location.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"

namespace turgor::lattice {

namespace {

constexpr double kMaxSkinDistance = 0.1;  // largest distance of the skin from the drawn line [m]

Vec3d skin_corner(const Model& model, const Motion& motion, const SkinTriangle& t, int corner) {
  return Vec3d(position(model, motion, slot_node(model.anatomy.lattice, t.vertex[corner])));
}

/// Distance along `direction` at which a line meets a triangle; NaN if it does not. [Möller, Trumbore 1997]
double meet(Vec3d origin, Vec3d direction, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d e1 = b - a, e2 = c - a, p = cross(direction, e2);
  const double det = dot(e1, p);
  if (det == 0) return std::numeric_limits<double>::quiet_NaN();
  const Vec3d s = origin - a, q = cross(s, e1);
  const double u = dot(s, p) / det, v = dot(direction, q) / det;
  constexpr double kSlack = 1e-9;  // relative size; a shared edge belongs to both triangles
  const bool inside = u >= -kSlack && v >= -kSlack && u + v <= 1 + kSlack;
  return inside ? dot(e2, q) / det : std::numeric_limits<double>::quiet_NaN();
}

/// Vertices of the skin, patient frame [m].
std::vector<Vec3d> skin_points(const Model& model, const Motion& motion) {
  std::vector<Vec3d> points;
  for (const SkinTriangle& t : model.anatomy.skin.triangles)
    for (int corner = 0; corner < 3; corner++)
      points.push_back(model.anatomy.grid.origin +
                       model.anatomy.grid.axes * skin_corner(model, motion, t, corner));
  return points;
}

}  // namespace

SkinNow skin_near(const Model& model, const Motion& motion, const std::vector<Vec3d>& curve,
                  const HaloExchange* halo) {
  Box box = box_around(curve);
  const double reach = kMaxSkinDistance + reach_of_directions(model.anatomy.lattice) +
                       3 * largest_spacing(model.anatomy.lattice);
  box.low -= Vec3d{reach, reach, reach}, box.high += Vec3d{reach, reach, reach};
  SkinNow near;
  // skin of the owned layers, then of all processes
  for (const SkinTriangle& t : skin_of_cells(model, model.anatomy.owned))
    if (const Vec3d a = skin_corner(model, motion, t, 0); squared_distance(box, a) == 0)
      near.push_back({a, skin_corner(model, motion, t, 1), skin_corner(model, motion, t, 2)});
  if (halo) halo->join_skin(near);
  return near;
}

Vec3d direction_into(const SkinNow& skin, Vec3d point, Vec3d line, double around) {
  // nearest skin vertex
  double nearest = std::numeric_limits<double>::max();
  Vec3d center;
  for (const auto& corner : skin)
    if (norm(corner[0] - point) < nearest) nearest = norm(corner[0] - point), center = corner[0];
  // area-weighted mean normal
  Vec3d normal;
  for (const auto& [a, b, c] : skin)
    if (!(norm(a - center) > around)) normal += cross(b - a, c - a);
  return normalized(line * dot(normal, line) - normal);
}

std::optional<double> distance_to_skin(const SkinNow& skin, Vec3d point, Vec3d into, Vec3d epsilon) {
  for (const Vec3d origin : {point - epsilon, point + epsilon}) {
    std::optional<double> best;
    for (const auto& [a, b, c] : skin)
      if (const double t = meet(origin, into, a, b, c);
          std::abs(t) < std::abs(best.value_or(kMaxSkinDistance)))
        best = t;
    if (best) return best;
  }
  return {};
}

std::string off_skin(const Model& model, const Motion& motion, const std::string& prefix, Vec3d point) {
  const Vec3d patient = model.anatomy.grid.origin + model.anatomy.grid.axes * point;
  return prefix + "no skin within " + number_text(kMaxSkinDistance) + " m of " + position_text(patient) +
         ": expected a line on the skin; " + describe_location(skin_points(model, motion), patient);
}

}  // namespace turgor::lattice
