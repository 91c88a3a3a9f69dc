// Two-level preconditioner. Blocks of adjacent vertices move as rigid bodies, and the Galerkin operator of
// these motions is factored in each step. Sweeps and plain conjugate gradients spread corrections by
// one edge an iteration; the coarse correction acts on the whole sheet [two-level additive Schwarz: Dryja,
// Widlund 1987; rigid modes: Vaněk, Mandel, Brezina 1996].
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/two_level_system.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct Model;
struct State;

/// Partition of the vertices into blocks of at most 0.7 √n.
Blocks make_blocks(const Model& model);

/// Assembles and factors the coarse operator of an assembled system.
void factor_coarse_system(const Exec& exec, const Model& model, const State& state, TwoLevelSystem& system);
/// Adds the coarse correction R (Rᵀ W R)⁻¹ Rᵀ r to z, R the rigid motions of the blocks.
void add_coarse_correction(const Exec& exec, const Model& model, const State& state, TwoLevelSystem& system,
                           const Vectors& r, Vectors& z);
std::size_t coarse_system_bytes(const TwoLevelSystem& system);

}  // namespace turgor::cloth
