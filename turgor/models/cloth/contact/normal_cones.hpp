// Normal cones of vertices and edges, for host and device. Two sheets are nearest to each other where the
// direction between two features is in the normal cones of both: it leads away from all triangles around a
// feature. Elsewhere nearer points have the contact. A contact with such a tilted direction would catch a
// sheet that slides. [Chen et al. 2025, Offset Geometric Contact, calls the cones offset blocks.]
#pragma once

#include <cmath>

#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

/// Sine of the angle by which a direction may leave the cone of a vertex, or that of an edge toward a vertex.
/// Rounding leaves no gap between the cones of adjacent features.
constexpr Real kConeMargin = Real(0.005);
/// Sine of the angle by which the direction between two edges must be inside their cones. Flat sheets are
/// kept apart by vertices and triangles.
constexpr Real kEdgeDepth = Real(0.01);

/// Positions, and neighbors of vertices whose cone is known (LargePrimitives::stars).
struct ConesView {
  ConstVectorsView x;
  const int *begin, *item;  // null if no triangle is large

  /// Tests whether a direction is in the normal cone of a vertex: no neighbor is nearer to where it leads.
  TURGOR_HD bool vertex_has(int v, Vec3 direction) const {
    if (begin == nullptr) return true;
    const Vec3 at = x[std::size_t(v)];
    const Real limit = kConeMargin * kConeMargin * dot(direction, direction);
    for (int n = begin[v]; n < begin[v + 1]; n++) {
      const Vec3 side = x[std::size_t(item[n])] - at;
      const Real along = dot(direction, side);
      if (along > 0 && along * along > limit * dot(side, side)) return false;
    }
    return true;
  }

  /// Direction of the steepest neighbor of a vertex toward which a direction leads; 0 without one.
  TURGOR_HD Vec3 steepest(int v, Vec3 direction) const {
    const Vec3 at = x[std::size_t(v)];
    Vec3 found;
    Real most = 0;
    for (int n = begin[v]; n < begin[v + 1]; n++) {
      const Vec3 side = normalized(x[std::size_t(item[n])] - at);
      if (const Real along = dot(direction, side); along > most) most = along, found = side;
    }
    return found;
  }
  /// Projects a direction onto the normal cone of a vertex: onto the plane normal to the steepest neighbor,
  /// and if another one is still steep, onto the line normal to both. A flat sheet has its normal.
  TURGOR_HD Vec3 projected(int v, Vec3 direction) const {
    const Vec3 first = steepest(v, direction), on_plane = direction - first * dot(direction, first);
    const Vec3 line = cross(first, steepest(v, on_plane));
    const Real length2 = dot(line, line);
    return length2 > Real(1e-4) ? line * (dot(direction, line) / length2) : on_plane;
  }

  /// Tests whether a direction normal to an edge leads away from the triangle of the edge and `corner`; -1 =
  /// no triangle. `margin` is the sine of the angle by which it may lead toward it.
  TURGOR_HD bool edge_has(Vec3 from, Vec3 edge, int corner, Vec3 direction, Real margin) const {
    if (corner < 0) return true;
    Vec3 inward = x[std::size_t(corner)] - from;
    inward -= edge * (dot(inward, edge) / dot(edge, edge));
    return dot(direction, inward) <= margin * std::sqrt(dot(direction, direction) * dot(inward, inward));
  }
};

}  // namespace turgor::cloth
