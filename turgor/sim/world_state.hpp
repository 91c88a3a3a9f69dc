// Copies of a world: whole, or only its state. A copy continues with the same bits as the original. Copies
// are made between two frames or ticks, while no other thread uses the world.
#pragma once

#include <cstdint>

#include "turgor/sim/world.hpp"

namespace turgor {

/// State of a world, without immutable data.
struct WorldState {
  World world;  // bodies without models and CTs
};

/// Waits for patches under construction, as the two functions below.
WorldState state_of(World& world);
/// The state is of this world, of a copy of it, or of a world of the same scene.
void set_state(World& world, const WorldState& state);
/// The same from a copy of this world, which may have fetched further columns of Green's functions.
void take_state(World& world, World& from);
/// Independent copy with models.
World copy_of(const World& world);

/// Hash of the cuts and removed nodes of all lattices. Where it is equal, surfaces have equal triangles.
std::uint64_t cuts_hash(const World& world);

}  // namespace turgor
