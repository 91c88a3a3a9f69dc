// Between the nodes of a body and the corners of its coarse space: what forces on nodes and copies do to
// corners, and how nodes and copies go where corners do. Nodes of half a row that follow one block differ in
// one of their three weights alone, so they are worked on together.
#pragma once

#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

/// What follows the unknowns in all layers, in the order of slots. `follows`: CoarseSpace::follows.
std::vector<FollowRun> find_follow_runs(const Lattice& lattice, std::span<const int> follows);

/// Adds the forces at the nodes of a layer to those at rows of CoarseSpace::row_begin [N].
void add_to_corners(const CoarseSpace& space, int k, LayerForces forces, std::span<Vec3d> sums);
/// And those at copies, State::left_over.
void add_copies_to_corners(const Model& model, const State& state, std::span<Vec3d> sums);
/// Nodes and copies go where rows of CoarseSpace::row_begin do [m].
void move_followers(const Exec& exec, const Model& model, State& state, std::span<const Vec3> corners);

}  // namespace turgor::lattice
