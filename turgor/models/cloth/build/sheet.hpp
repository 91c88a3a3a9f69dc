// Rectangles of triangles, to be cloth.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::cloth {

/// Spanned by two sides from a corner, `columns` × `rows` rectangles, each split in two from its
/// corner nearest to the sheet's. Vertices are numbered along `side`, then along `up`.
struct Sheet {
  Vec3d corner, side{1, 0, 0}, up{0, 1, 0};  // [m]
  int columns = 50, rows = 50;
};
TriMesh make_sheet(const Sheet& sheet);

}  // namespace turgor::cloth
