// Rectangular triangle meshes.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::cloth {

/// Rectangle spanned by `side` and `up` from `corner`, with `columns` × `rows` cells. Each cell is split
/// along the diagonal from its corner nearest to `corner`. Vertices are numbered along `side`, then along
/// `up`.
struct Sheet {
  Vec3d corner, side{1, 0, 0}, up{0, 1, 0};  // [m]
  int columns = 50, rows = 50;
};
TriMesh make_sheet(const Sheet& sheet);

}  // namespace turgor::cloth
