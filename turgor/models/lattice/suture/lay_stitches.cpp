// Positions of stitches and wall pairs on a wound, and their embedding in its tissue.
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/models/lattice/cutting/ct_skin.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"
#include "turgor/models/lattice/cutting/rim.hpp"
#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {

namespace {

/// Frame of a wound at an arc length: points of both lips on the skin, into the body there, and from left to
/// right.
struct WoundFrame {
  Vec3d left, right, left_inward, right_inward, across;

  Vec3d middle() const { return (left + right) / 2; }
  Vec3d inward() const { return normalized(left_inward + right_inward); }
  double gap() const { return dot(right - left, across); }
};

/// Line along which a wound is closed: the path of a cut, or the length of an excision between its lips.
struct WoundLine {
  const BladePath& path;
  BladePath line;

  explicit WoundLine(const BladePath& p) : path(p), line(p.is_excision ? axis_of(p) : p) {}
  double length() const { return path_length(line); }

  WoundFrame frame_at(double along) const {
    const PathPosition at = position_along(line, along);
    const std::size_t next = std::min(at.segment + 1, line.points.size() - 1);
    const auto mix = [&](Vec3d a, Vec3d b) { return a * (1 - at.fraction) + b * at.fraction; };
    if (!path.is_excision) {
      const Vec3d point = mix(path.points[at.segment], path.points[next]),
                  inward = normalized(mix(path.inward[at.segment], path.inward[next]));
      return {point, point, inward, inward,
              normalized(mix(across_at(path, at.segment), across_at(path, next)))};
    }
    const std::size_t last = path.points.size() - 1;
    WoundFrame frame{.left = mix(path.points[last - at.segment], path.points[last - next]),
                     .right = mix(path.points[at.segment], path.points[next]),
                     .left_inward = normalized(mix(path.inward[last - at.segment], path.inward[last - next])),
                     .right_inward = normalized(mix(path.inward[at.segment], path.inward[next])),
                     .across = {}};
    frame.across = normalized(frame.right - frame.left);
    return frame;
  }
};

/// Arc length of the point of a wound's line nearest to a position [m].
double nearest_along(const WoundLine& wound, Vec3d position) {
  const BladePath& path = wound.line;
  double best = 0, least = -1, along = 0;
  for (std::size_t n = 0; n < path.points.size(); n++) {
    if (n > 0) along += norm(path.points[n] - path.points[n - 1]);
    const double distance = norm(path.points[n] - position);
    if (least < 0 || distance < least) least = distance, best = along;
  }
  return best;
}

Stitch stitch_at(const WoundLine& wound, double along, std::vector<Vec3d> points) {
  const WoundFrame at = wound.frame_at(along);
  Stitch stitch{
      .rest = std::move(points), .along = along, .middle = at.middle(), .across = at.across, .gap = at.gap()};
  for (const Vec3d p : stitch.rest) stitch.side.push_back(dot(p - at.middle(), at.across) < 0 ? -1 : 1);
  return stitch;
}

/// Loop from the skin on the left, below the wound, to the skin on the right.
Stitch stitch_across(const WoundLine& wound, double along, const StitchLayout& layout) {
  const WoundFrame at = wound.frame_at(along);
  // along the skin, away from the wound
  const auto aside = [&](Vec3d inward) {
    return normalized(at.across - inward * dot(at.across, inward)) * layout.bite;
  };
  const Vec3d left = at.left - aside(at.left_inward), right = at.right + aside(at.right_inward);
  Stitch stitch =
      stitch_at(wound, along,
                {left, left + at.left_inward * layout.depth, right + at.right_inward * layout.depth, right});
  stitch.keeps_bites = true;
  return stitch;
}

/// Opens the stitches of a row, whose thread then goes on to the first point of the next one.
void open_stitches(std::vector<Stitch>& stitches) {
  for (std::size_t n = 0; n < stitches.size(); n++) {
    const Stitch& next = stitches[n + 1 < stitches.size() ? n + 1 : n];
    stitches[n].rest.push_back(next.rest.front()), stitches[n].side.push_back(next.side.front());
    stitches[n].is_open = true;
  }
}

std::vector<Stitch> stitches_of(const WoundLine& wound, const StitchLayout& layout) {
  std::vector<Stitch> stitches;
  // single stitches
  for (const std::vector<Vec3d>& points : layout.through) {
    Vec3d middle;
    for (const Vec3d p : points) middle += p / double(points.size());
    stitches.push_back(stitch_at(wound, nearest_along(wound, middle), points));
  }
  if (!layout.through.empty()) return stitches;
  // a row
  const double length = wound.length();
  const int count = std::max(1, int(std::lround(length / layout.spacing)));
  for (int n = 0; n < count; n++)
    stitches.push_back(stitch_across(wound, (n + 0.5) * length / count, layout));
  if (layout.is_running) open_stitches(stitches);
  return stitches;
}

/// Pairs about one cell apart, on the wound's line and down to its depth.
std::vector<WallPair> walls_of(const Model& model, const WoundLine& wound) {
  const Vec3 h = model.anatomy.lattice.spacing;
  const double cell = double(std::max({h.x, h.y, h.z})), length = wound.length(), depth = wound.path.depth;
  const int count = std::max(1, int(std::ceil(length / cell))),
            layers = std::max(1, int(std::ceil(depth / cell)));
  std::vector<WallPair> walls;
  for (int n = 0; n < count; n++) {
    const double along = (n + 0.5) * length / count;
    const WoundFrame at = wound.frame_at(along);
    for (int k = 0; k < layers; k++) {
      const double below = (k + 0.5) * depth / layers;
      const Vec3d left = at.left + at.left_inward * below, right = at.right + at.right_inward * below;
      walls.push_back({.rest = (left + right) / 2,
                       .normal = at.across,
                       .gap = dot(right - left, at.across),
                       .along = along});
    }
  }
  return walls;
}

/// Share of its length in the CT by which skin retracts when its tension is released.
double retraction(const Model& model) {
  const SkinParams& skin = model.params.skin;
  if (!skin.enabled || skin.law != SkinLaw::kFiber) return 0;
  return 1 - double(fiber_rest(std::max(skin.tension_along, skin.tension_across), skin));
}

/// Middle of the bite that begins at a point of a stitch of a row, lattice frame [m].
Vec3d bite_middle(const Stitch& stitch, int point) {
  return (stitch.rest[std::size_t(point)] + stitch.rest[std::size_t(point + 1)]) / 2;
}

/// Rims between the bites of a row of stitches and the lips. They are as stiff as dermis, of which the
/// lattice has only the tension: without them, stitches would crush the rim before the lips meet.
void add_rims(const Model& model, const StitchLayout& layout, WoundClosure& closure) {
  for (std::size_t n = 0; n < closure.stitches.size(); n++) {
    const Stitch& stitch = closure.stitches[n];
    if (!stitch.keeps_bites) continue;
    for (const int p : {0, 2}) {
      const std::size_t on_skin = p == 0 ? 0 : 3;
      closure.walls.push_back(
          {.rest = stitch.middle + stitch.across * (stitch.side[on_skin] * stitch.gap / 2),
           .normal = stitch.across,
           .gap = retraction(model) * layout.bite,
           .along = stitch.along,
           .stitch = int(n),
           .point = p});
    }
  }
}

constexpr double kAside = 0.02;  // of embedded points from the blade [cells]

/// Rim between a point of a stitch and its lip.
EmbeddedPair embed_rim(const Model& model, const Cuts& cuts, const Fragments& fragments, const Stitch& stitch,
                       const WallPair& rim) {
  const auto p = std::size_t(rim.point);
  const Vec3d aside = rim.normal * (stitch.side[p] * kAside * smallest_spacing(model.anatomy.lattice));
  const auto lip = embed_point(model, cuts, fragments, rim.rest + aside);
  if (!lip || !stitch.lips.parted) return {};
  return stitch.side[p] < 0 ? EmbeddedPair{stitch.at[p], *lip, true} : EmbeddedPair{*lip, stitch.at[p], true};
}

EmbeddedPair embed_pair(const Model& model, const Cuts& cuts, const Fragments& fragments, Vec3d middle,
                        Vec3d across, double gap) {
  const Vec3d aside = across * (kAside * smallest_spacing(model.anatomy.lattice) + gap / 2);
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

/// Positions whose tissue moves the points of a stitch. A bite of a row moves as one: with its middle or, in
/// partial cells, with the skin at its upper end. Skin lies in these cells, not in their nodes. The tissue
/// below it is so soft that it would follow the thread without the skin. For the same reason, points of a
/// single stitch move with the skin if they are less than a spacing below it.
std::vector<Vec3d> embedded_points(const Model& model, const Stitch& stitch) {
  const bool by_skin = !model.anatomy.skin.patches.empty();
  if (!stitch.keeps_bites) return by_skin ? lifted_to_patches(model, stitch.rest) : stitch.rest;
  const Vec3d left = by_skin ? stitch.rest[0] : bite_middle(stitch, 0),
              right = by_skin ? stitch.rest[3] : bite_middle(stitch, 2);
  std::vector<Vec3d> points{left, left, right, right};
  // a running thread goes on to a bite of another stitch, below the skin
  if (stitch.is_open) points.push_back(stitch.rest.back() + left - stitch.rest.front());
  return points;
}

/// Length of a loop beyond which pulling would crush the tissue: that with closed lips and rims without
/// tension, less some stretch of the thread; without rims a share of the length in the CT [m].
double shortest_loop(const Stitch& stitch, double retraction, double bite) {
  constexpr double kShare = 0.7, kStretch = 0.03;
  const double rest = rest_length(stitch);
  return stitch.keeps_bites ? rest - 4 * bite * (retraction + kStretch) : kShare * rest;
}

/// Path of a wound on the skin that bears.
BladePath on_skin(const Model& model, BladePath path) {
  if (model.anatomy.skin.patches.empty() || path.is_excision) return path;
  const std::vector<double> heights = patch_heights(model, path.points, path.inward);
  for (std::size_t n = 0; n < path.points.size(); n++) path.points[n] -= path.inward[n] * heights[n];
  return path;
}

/// Embeds all points. Returns the first point of a stitch that is not in tissue.
std::optional<Vec3d> embed(const Model& model, const Cuts& cuts, WoundClosure& closure) {
  const auto fragments = fragments_of(model, cuts);
  std::optional<Vec3d> missed;
  for (Stitch& stitch : closure.stitches) {
    stitch.at.clear();
    for (const Vec3d p : embedded_points(model, stitch)) {
      const auto point = embed_point(model, cuts, *fragments, p);
      if (!point && !missed) missed = p;
      stitch.at.push_back(point.value_or(EmbeddedPoint{}));
    }
    stitch.lips = embed_pair(model, cuts, *fragments, stitch.middle, stitch.across, stitch.gap);
  }
  for (WallPair& pair : closure.walls) {
    if (pair.stitch < 0) {
      pair.at = embed_pair(model, cuts, *fragments, pair.rest, pair.normal, pair.gap);
      continue;
    }
    pair.at = embed_rim(model, cuts, *fragments, closure.stitches[std::size_t(pair.stitch)], pair);
  }
  closure.version = cut_version(cuts);
  return missed;
}

}  // namespace

Result<WoundClosure> lay_stitches(const Model& model, const Cuts& cuts, const BladePath& path,
                                  const StitchLayout& layout) {
  TURGOR_ASSERT(layout.spacing > 0 && layout.bite > 0, "stitches have a distance and a bite");
  WoundClosure closure;
  const BladePath laid = on_skin(model, path);
  const WoundLine wound(laid);
  closure.stitches = stitches_of(wound, layout);
  closure.walls = walls_of(model, wound), closure.is_running = layout.is_running;
  add_rims(model, layout, closure);
  for (Stitch& stitch : closure.stitches)
    stitch.shortest = shortest_loop(stitch, retraction(model), layout.bite);
  if (const auto missed = embed(model, cuts, closure))
    return Error{"a stitch passes through air at " + point_text(model, *missed)};
  return closure;
}

std::optional<double> distance_to_wound(const BladePath& path, std::span<const Vec3d> points) {
  TURGOR_ASSERT(!points.empty(), "a stitch has points");
  Vec3d middle;
  for (const Vec3d p : points) middle += p / double(points.size());
  const WoundLine wound(path);
  const Stitch stitch =
      stitch_at(wound, nearest_along(wound, middle), std::vector<Vec3d>(points.begin(), points.end()));
  if (std::count(stitch.side.begin(), stitch.side.end(), stitch.side[0]) == std::ptrdiff_t(points.size()))
    return std::nullopt;
  return norm(middle - stitch.middle);
}

bool embed_closure(const Model& model, const Cuts& cuts, WoundClosure& closure) {
  return !embed(model, cuts, closure);
}

double rest_length(const Stitch& stitch) {
  // points with the lips together
  std::vector<Vec3d> points = stitch.rest;
  for (std::size_t p = 0; p < points.size(); p++)
    points[p] -= stitch.across * (stitch.side[p] * stitch.gap / 2);
  double length = 0;
  for (std::size_t p = 0; p + (stitch.is_open ? 1 : 0) < points.size(); p++)
    length += norm(points[(p + 1) % points.size()] - points[p]);
  return length;
}

}  // namespace turgor::lattice
