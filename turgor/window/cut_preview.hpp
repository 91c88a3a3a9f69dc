// Line on the skin along which a blade would cut, shown while it is drawn.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Pieces of a curve, in any order [m].
struct SkinLine {
  struct Piece {
    Vec3d from, to;
  };
  std::vector<Piece> pieces;
  Vec3d outward;      // unit, mean normal at both ends
  double length = 0;  // of all pieces [m]
};

/// Intersection of a surface with the plane through two of its points and the mean of their unit normals,
/// between these points. Triangles that face inward are left out.
SkinLine line_on_skin(std::span<const Vec3> x, std::span<const Int3> triangles, Vec3d from, Vec3d from_normal,
                      Vec3d to, Vec3d to_normal);

}  // namespace turgor
