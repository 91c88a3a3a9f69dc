// Bodies and tools in a recording: surfaces as pictures show them, and what every tool felt in every tick.
// Enough to draw and to plot a run again without its Green's functions.
#pragma once

#include <vector>

#include "turgor/sim/pressed.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// The surface as it is shown, with the tools on it.
Status write_state(const SnapshotOut& out, const SfemBody& body, BodyId id);
Status write_state(const SnapshotOut& out, const RhombusBody& body, BodyId id);
/// Error: arrays are missing or of other sizes, or a triangle has a corner that is not there.
Status read_state(const SnapshotIn& in, SfemBody& body, BodyId id);
Status read_state(const SnapshotIn& in, RhombusBody& body, BodyId id);

/// The tools on a lattice or a cloth, if there are any: its surface comes from its state.
Status write_tools(const SnapshotOut& out, const TouchedBody& body, BodyId id);
/// The tools on a body, with the surface that was recorded.
Status read_tools(const SnapshotIn& in, const TouchedBody& body, BodySnapshot& surface);

/// Samples of all tools, and every body when it was pressed most.
Status write_touch(Hdf5File& file, const World& world, const WorldSnapshot& snapshot,
                   const std::vector<Pressed>& pressed);
Status read_touch(const Hdf5File& file, World& world, std::vector<Pressed>& pressed);

}  // namespace turgor
