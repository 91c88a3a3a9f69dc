// Points of the drawn skin on blades, by Newton's method. A blade is a plane near the point
// (blade_plane.hpp). The skin is the zero set of the levels, linear in each tetrahedron of the fine lattice.
// A point that moves out of its own tetrahedron stays on the skin.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "turgor/models/lattice/surface/blade_plane.hpp"
#include "turgor/models/lattice/surface/ct_level_set.hpp"

namespace turgor::lattice {

/// Level and its gradient at a position.
struct LevelAt {
  double level = 0;  // [HU]
  Vec3d gradient;    // [HU per cell]
};

/// Levels of a cell and of the 26 cells around it, computed when they are first needed.
class LevelsNear {
 public:
  LevelsNear(const CtLevelSet& level, const FineLattice& fine) : level_(level), fine_(fine) {}

  /// Moves to another cell.
  void begin_cell(Int3 cell);
  /// Positions beyond the cells around are moved to their border [cells].
  LevelAt at(Vec3d position);

 private:
  const CellLevels& levels_of(Int3 cell);

  const CtLevelSet& level_;
  const FineLattice& fine_;
  Int3 cell_;
  std::array<std::optional<CellLevels>, 27> levels_;
};

/// Intersection of the skin with the blades of one or two cut edges, near a position.
struct SkinOnBlades {
  const FineLattice& fine;
  std::span<const CutPoint> cut_points;
  LevelsNear& levels;

  /// Empty if a blade is not known there, if the surfaces are nearly parallel, or if they do not meet within
  /// `reach` of the position [cells].
  std::optional<Vec3d> operator()(std::span<const CutEdge* const> blades, Vec3d position, double reach) const;
};

}  // namespace turgor::lattice
