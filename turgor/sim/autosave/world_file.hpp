// State of a world in a file (state_file.hpp). A world of the same scene that reads it continues with the
// same bits as the world that wrote it, on any number of threads.
#pragma once

#include <memory>
#include <vector>

#include "turgor/sim/autosave/state_file.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Patches that a world has after loading, one for each sfem body. Files refer to them instead of storing
/// them, because loading builds them again. They are kept, since a file may be read after the tools have left
/// them.
struct LoadedPatches {
  std::vector<std::shared_ptr<const sfem::Patch>> patches;
};
LoadedPatches loaded_patches(const World& world);

/// Hash of a loaded world with its inputs: equal for worlds that may exchange their states.
std::uint64_t loaded_hash(const World& world);

/// Writes the state of a world between two frames, without a haptic thread.
void write_world(StateWriter& file, const World& world, const LoadedPatches& loaded);
/// Reads it into a loaded world of the same scene. The reader tells whether it was sound.
void read_world(const Exec& exec, StateReader& file, const LoadedPatches& loaded, World& world);

}  // namespace turgor
