// A world copied: whole, or all of it but what never changes while it is simulated. A copy goes on as its
// original does, to the same bits; between two frames or two ticks, while no other thread is at the world.
#pragma once

#include "turgor/sim/world.hpp"

namespace turgor {

/// What changes of a world while it is simulated.
struct WorldState {
  World world;  // its bodies have no models and no CTs
};

/// Waits for patches that are being built, as the two below do.
WorldState state_of(World& world);
/// The state is of this world, of a copy of it, or of a world of the same scene.
void set_state(World& world, const WorldState& state);
/// Another world of its own, models included.
World copy_of(const World& world);

}  // namespace turgor
