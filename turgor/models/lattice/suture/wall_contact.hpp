// Contact of the walls of a wound; closure.cpp calls these functions.
#pragma once

#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {

/// Penalty stiffness near a cell, about that of its tissue and skin [N/m]. A stiffer one would slow the
/// sweeps down; the multipliers bring what it lacks.
double penalty_at(const Model& model, const EmbeddedPoint& point);
/// The same for the walls of a wound, or for those of a closure that has come to rest [N/m].
double wall_stiffness(const Model& model, const WallPair& pair, bool is_settled);
/// Distance of two wall points along the normal [m]; negative if they overlap.
double gap_of(const WallPair& pair, const Motion& motion);
/// k g gᵀ.
PointStiffness outer(Vec3d g, double k);
/// Updates a wall pair and its two springs: N = max(0, λ − κ (gap + n·(u_right − u_left))).
void update_wall(const Model& model, const Motion& motion, bool is_settled, WallPair& pair,
                 std::span<PointSpring> springs);

}  // namespace turgor::lattice
