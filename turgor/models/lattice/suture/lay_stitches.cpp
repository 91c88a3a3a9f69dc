// Positions of stitches and wall pairs on a wound, and their embedding in its tissue.
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {

namespace {

/// Frame of a wound at an arc length: point on the skin, into the body, and from left to right.
struct WoundFrame {
  Vec3d point, inward, across;
};
WoundFrame frame_at(const BladePath& path, double along) {
  const PathPosition at = position_along(path, along);
  const std::size_t next = std::min(at.segment + 1, path.points.size() - 1);
  const auto mix = [&](Vec3d a, Vec3d b) { return a * (1 - at.fraction) + b * at.fraction; };
  return {mix(path.points[at.segment], path.points[next]),
          normalized(mix(path.inward[at.segment], path.inward[next])),
          normalized(mix(across_at(path, at.segment), across_at(path, next)))};
}

/// Arc length of the path's point nearest to a position [m].
double nearest_along(const BladePath& path, Vec3d position) {
  double best = 0, least = -1, along = 0;
  for (std::size_t n = 0; n < path.points.size(); n++) {
    if (n > 0) along += norm(path.points[n] - path.points[n - 1]);
    const double distance = norm(path.points[n] - position);
    if (least < 0 || distance < least) least = distance, best = along;
  }
  return best;
}

Stitch stitch_at(const BladePath& path, double along, std::vector<Vec3d> points) {
  const WoundFrame at = frame_at(path, along);
  Stitch stitch{.rest = std::move(points), .along = along, .middle = at.point, .across = at.across};
  for (const Vec3d p : stitch.rest) stitch.side.push_back(dot(p - at.point, at.across) < 0 ? -1 : 1);
  return stitch;
}

/// Loop from the skin on the left, below the wound, to the skin on the right.
Stitch stitch_across(const BladePath& path, double along, const StitchLayout& layout) {
  const WoundFrame at = frame_at(path, along);
  const Vec3d aside = at.across * layout.bite, down = at.inward * layout.depth;
  return stitch_at(path, along,
                   {at.point - aside, at.point - aside + down, at.point + aside + down, at.point + aside});
}

std::vector<Stitch> stitches_of(const BladePath& path, const StitchLayout& layout) {
  std::vector<Stitch> stitches;
  // single stitches
  for (const std::vector<Vec3d>& points : layout.through) {
    Vec3d middle;
    for (const Vec3d p : points) middle += p / double(points.size());
    stitches.push_back(stitch_at(path, nearest_along(path, middle), points));
  }
  if (!layout.through.empty()) return stitches;
  // a row
  const double length = path_length(path);
  const int count = std::max(1, int(std::lround(length / layout.spacing)));
  for (int n = 0; n < count; n++) stitches.push_back(stitch_across(path, (n + 0.5) * length / count, layout));
  return stitches;
}

/// Pairs about one cell apart, on the path and down to its depth.
std::vector<WallPair> walls_of(const Model& model, const BladePath& path) {
  const Vec3 h = model.anatomy.lattice.spacing;
  const double cell = double(std::max({h.x, h.y, h.z})), length = path_length(path);
  const int count = std::max(1, int(std::ceil(length / cell))),
            layers = std::max(1, int(std::ceil(path.depth / cell)));
  std::vector<WallPair> walls;
  for (int n = 0; n < count; n++) {
    const double along = (n + 0.5) * length / count;
    const WoundFrame at = frame_at(path, along);
    for (int k = 0; k < layers; k++)
      walls.push_back({.rest = at.point + at.inward * ((k + 0.5) * path.depth / layers),
                       .normal = at.across,
                       .along = along});
  }
  return walls;
}

EmbeddedPair embed_pair(const Model& model, const Cuts& cuts, const Fragments& fragments, Vec3d middle,
                        Vec3d across) {
  constexpr double kAside = 0.02;  // [cells]
  const Vec3 h = model.anatomy.lattice.spacing;
  const Vec3d aside = across * (kAside * double(std::min({h.x, h.y, h.z})));
  const auto left = embed_point(model, cuts, fragments, middle - aside),
             right = embed_point(model, cuts, fragments, middle + aside);
  if (!left || !right || left->corner == right->corner) return {};
  return {*left, *right, true};
}

/// Text of a point of the lattice frame in the patient frame.
std::string point_text(const Model& model, Vec3d point) {
  const Vec3d p = model.anatomy.grid.origin + model.anatomy.grid.axes * point;
  return "[" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + "] m";
}

/// Embeds all points. Returns the first point of a stitch that is not in tissue.
std::optional<Vec3d> embed(const Model& model, const Cuts& cuts, WoundClosure& closure) {
  const auto fragments = fragments_of(model, cuts);
  std::optional<Vec3d> missed;
  for (Stitch& stitch : closure.stitches) {
    stitch.at.clear();
    for (const Vec3d p : stitch.rest) {
      const auto point = embed_point(model, cuts, *fragments, p);
      if (!point && !missed) missed = p;
      stitch.at.push_back(point.value_or(EmbeddedPoint{}));
    }
    stitch.lips = embed_pair(model, cuts, *fragments, stitch.middle, stitch.across);
  }
  for (WallPair& pair : closure.walls) pair.at = embed_pair(model, cuts, *fragments, pair.rest, pair.normal);
  closure.version = cut_version(cuts);
  return missed;
}

}  // namespace

Result<WoundClosure> lay_stitches(const Model& model, const Cuts& cuts, const BladePath& path,
                                  const StitchLayout& layout) {
  TURGOR_ASSERT(layout.spacing > 0 && layout.bite > 0, "stitches have a distance and a bite");
  WoundClosure closure;
  closure.stitches = stitches_of(path, layout);
  closure.walls = walls_of(model, path);
  if (const auto missed = embed(model, cuts, closure))
    return Error{"a stitch passes through air at " + point_text(model, *missed)};
  return closure;
}

bool embed_closure(const Model& model, const Cuts& cuts, WoundClosure& closure) {
  return !embed(model, cuts, closure);
}

double rest_length(const Stitch& stitch) {
  double length = 0;
  for (std::size_t p = 0; p < stitch.rest.size(); p++)
    length += norm(stitch.rest[(p + 1) % stitch.rest.size()] - stitch.rest[p]);
  return length;
}

}  // namespace turgor::lattice
