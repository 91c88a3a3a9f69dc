// Assembly of the drawn surface from the points of the fine lattice's tetrahedra. Points near cuts are kept.
// Elsewhere the points in a box of two thirds of a cell are merged into one vertex, so the surface has about
// as many triangles as the lattice's own skin.
#pragma once

#include "turgor/core/key_index.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

constexpr int kSkin = 0, kFirstCap = 1, kWall = 7,
              kSurfaceGroups = 8;  // groups with separate vertices and normals

struct SurfacePoint {
  Vec3d position;  // [cells]
  EmbeddingCell embedding;
  std::uint8_t border = 0;   // bit 2 axis + end: on that border of the lattice
  bool is_skin = false;      // on an edge from tissue to air
  bool is_near_cut = false;  // not merged
};

struct Points {
  std::vector<SurfacePoint> all;
  std::array<std::vector<Int3>, kSurfaceGroups> triangles;
  std::vector<Lip> lips;  // pairs of points
};

/// Points and triangles of a slab, in the order in which they were found.
struct SlabPoints {
  KeyIndex index;
  std::vector<std::uint64_t> keys;  // of the points
  Points points;
};
/// Slabs of cells from an earlier call. A slab without cuts and removed nodes always has the same points.
struct SurfaceCache {
  std::vector<SlabPoints> slabs;
  std::vector<std::uint8_t> is_whole;  // by slab: without cuts and removed nodes at that time
};
/// Concatenates adjacent slabs. A point shared with the slab below gets its number in that slab, as in a
/// single pass over all cells.
Points concatenate_slabs(const std::vector<SlabPoints>& slabs);

/// Fills in everything except the fragments. Points are merged by position alone, so a closed surface remains
/// closed.
void assemble_surface(const Model& model, const Cuts& cuts, const Points& points, BodySurface& surface);

}  // namespace turgor::lattice::detail
