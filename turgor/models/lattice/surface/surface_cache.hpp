// Drawn surface of a body while it is being cut. The surface without blades is meshed once. After a cut, only
// cells near blades whose cuts changed are meshed again, and only the merged points around them change. The
// result has the same bits as a surface that is built at once.
#pragma once

#include "turgor/models/lattice/surface/surface_assembly.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"

namespace turgor::lattice::detail {

/// Merged surface without blades. Vertices are numbered by their merge keys.
struct UncutSurface {
  KeyIndex boxes;  // from merge key to vertex
  MergedSurface merged;
};

/// Mesh of one cell, and a hash of the cuts that it depends on.
struct MeshedCell {
  int cell = 0;  // cell_index
  std::uint64_t cuts = 0;
  std::vector<std::uint64_t> keys;  // of the points
  Points points;
};

struct SurfaceCache {
  bool is_made = false;
  std::uint64_t removed = 0;  // hash of the removed tissue
  UncutSurface uncut;
  std::vector<MeshedCell> near;  // cells near blades and their neighbors, by ascending cell
  KeptTerms terms;
};

/// Surface without fragments for the present cuts. Brings the cache up to date.
BodySurface update_surface(const Exec& exec, const MeshInput& input, SurfaceCache& cache);

}  // namespace turgor::lattice::detail
