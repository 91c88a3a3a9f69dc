// Assembly of the drawn surface from the points of the fine lattice's tetrahedra. Points near cuts are kept.
// Elsewhere the points in a box of two thirds of a cell are merged into one vertex, so the surface has about
// as many triangles as the lattice's own skin.
#pragma once

#include "turgor/core/key_index.hpp"
#include "turgor/models/lattice/surface/ct_level_set.hpp"
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

/// Triangle and the cell that it was meshed in (cell_index).
struct CellTriangle {
  Int3 point;
  int cell = 0;
};

struct Points {
  std::vector<SurfacePoint> all;
  std::array<std::vector<CellTriangle>, kSurfaceGroups> triangles;
  std::vector<Lip> lips;  // pairs of points
};

/// Points and triangles of a slab or a cell, in the order in which they were found.
struct SlabPoints {
  KeyIndex index;
  std::vector<std::uint64_t> keys;  // of the points
  Points points;
};

/// Input of the meshing. `level` and `fragments` follow from the cuts.
struct MeshInput {
  const Model& model;
  const Cuts& cuts;
  const CtLevelSet& level;
  const Fragments& fragments;
};

/// Number of a cell in the order in which cells are meshed.
constexpr int cell_index(const Lattice& l, Int3 cell) {
  return cell.x + l.size.x * (cell.y + l.size.y * cell.z);
}
/// Meshes all cells. Points have the same numbers for any number of threads.
Points mesh_body(const Exec& exec, const MeshInput& input);
/// Meshes one cell.
SlabPoints mesh_cell(const MeshInput& input, Int3 cell);
/// Concatenates adjacent slabs. A point shared with the slab below gets its number in that slab, as in a
/// single pass over all cells.
Points concatenate_slabs(const std::vector<SlabPoints>& slabs);

/// Vertex of the surface before its groups are separated.
struct MergedVertex {
  Vec3 rest;  // lattice frame [m]
  EmbeddingCell embedding;
  int slot = 0;  // nearest node on its side of the cuts
};
/// Surface with merged points. Triangles and lips refer to `vertices`.
struct MergedSurface {
  std::vector<MergedVertex> vertices;
  std::array<std::vector<CellTriangle>, kSurfaceGroups> triangles;
  std::vector<Lip> lips;
};
/// Box of a merged point, and its key in the body. Points with different borders or kinds are not merged.
Int3 merge_box(const SurfacePoint& point);
std::uint64_t merge_key(const Model& model, const SurfacePoint& point);
/// Vertex of a point that is not merged.
MergedVertex separate_vertex(const MeshInput& input, const SurfacePoint& point);
/// Vertex of merged points. `position`: their mean [cells].
MergedVertex merged_vertex(const MeshInput& input, Vec3d position);

/// Gives each group its own vertices, and drops degenerate triangles. Fills in everything except the
/// fragments.
BodySurface separate_groups(const MergedSurface& merged);
/// Merges the points by position alone, so a closed surface remains closed.
BodySurface assemble_surface(const MeshInput& input, const Points& points);

}  // namespace turgor::lattice::detail
