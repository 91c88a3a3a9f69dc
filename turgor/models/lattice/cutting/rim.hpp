// Rim of an excised piece or of its wound: points on the skin next to the outline, and sizes that follow from
// their positions.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Distance of embedded points from the blade [cells].
constexpr double kAsideOfBlade = 0.05;

/// Points on the rim of an excision: those of the path, moved by `aside` away from the center [m].
std::vector<Vec3d> rim_points(const BladePath& path, double aside);
/// Path along the length of the outline, through the middles of opposite points.
BladePath axis_of(const BladePath& outline);

/// Size of an outline.
struct OutlineSize {
  double length = 0, width = 0;  // largest distances along and across [m]
  double area = 0;               // [m²]
};
/// Size of an outline whose points n and count − 1 − n are opposite, by chords.
OutlineSize size_of(std::span<const Vec3d> outline);

/// Points of the skin inside an outline: rows from its right side to its left one, kPointsAcross each.
constexpr std::size_t kPointsAcross = 9;
std::vector<Vec3d> points_inside(std::span<const Vec3d> outline);
/// Size along a surface with such points.
OutlineSize size_along_surface(std::span<const Vec3d> points);

/// Points that move with the tissue.
struct EmbeddedPoints {
  std::vector<Vec3d> rest;  // in the CT, lattice frame [m]
  std::vector<EmbeddedPoint> at;

  std::vector<Vec3d> now(const Motion& motion) const;
};
/// Embeds the points `inside` of the tissue for the points `rest`. One that is not in tissue moves with its
/// nearest neighbor in the list. Empty if none is.
std::optional<EmbeddedPoints> embed_all(const Model& model, const Cuts& cuts,
                                        const std::vector<Vec3d>& inside, const std::vector<Vec3d>& rest);

/// Opening of an excised wound: its rim at current positions, from chords. Empty if no point has tissue.
struct Opening {
  std::vector<Vec3d> rim;  // lattice frame, in the order of the path [m]
  OutlineSize size;
  double displacement = 0;  // largest of the rim, since the CT [m]
};
std::optional<Opening> opening_of(const Model& model, const State& state, const BladePath& path);

/// Largest displacement of the skin out of the body, since the CT, within half a width beyond each end of an
/// excised wound [m].
struct EndHeights {
  double first = 0, last = 0;
};
EndHeights heights_at_ends(const Model& model, const State& state, const BladePath& path);

}  // namespace turgor::lattice
