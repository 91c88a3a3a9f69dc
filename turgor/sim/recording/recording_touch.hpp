// Touched bodies and tools in a recording: drawn surfaces, and the logs of all tools. They are sufficient to
// draw and to plot a run without Green's functions.
#pragma once

#include <vector>

#include "turgor/sim/pressed.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Writes the drawn surface with its tools.
Status write_state(const SnapshotOut& out, const SfemBody& body, BodyId id);
Status write_state(const SnapshotOut& out, const RhombusBody& body, BodyId id);
/// Error: arrays are missing or have other sizes, or a triangle has an invalid index.
Status read_state(const SnapshotIn& in, SfemBody& body, BodyId id);
Status read_state(const SnapshotIn& in, RhombusBody& body, BodyId id);

/// Writes the tools on a lattice or a cloth, if any; its surface follows from its state.
Status write_tools(const SnapshotOut& out, const TouchedBody& body, BodyId id);
/// Reads the tools on a body and the recorded surface.
Status read_tools(const SnapshotIn& in, const TouchedBody& body, BodySnapshot& surface);

/// Logs of all tools, and every body under its largest force.
Status write_touch(Hdf5File& file, const World& world, const WorldSnapshot& snapshot,
                   const std::vector<Pressed>& pressed);
Status read_touch(const Hdf5File& file, World& world, std::vector<Pressed>& pressed);

}  // namespace turgor
