// State of a world in a file that a program writes and reads between two frames, with cuts and stitches by
// hand. The same program continues with it, in a world of the same scene (world_file.hpp).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/sim/autosave/world_file.hpp"

namespace turgor {

/// Identity of the program that writes states: another one may arrange a state otherwise, or round otherwise.
/// `more`: sizes of further structs in the file.
std::string state_program(std::vector<std::size_t> more = {});

/// Identity of a world after loading.
struct LoadedWorld {
  LoadedPatches patches;
  std::uint64_t hash = 0;  // loaded_hash
};
LoadedWorld loaded_world(const World& world);

/// Writes a world and its measures. On an error an earlier file of that name is kept.
Status save_world(const std::filesystem::path& path, const Scene& scene, const World& world,
                  const Measures& measures, const LoadedWorld& loaded);
/// Replaces the state of a world of the same scene; cuts and stitches by hand since loading are replaced too.
/// Arrays of bodies keep their memory.
/// Errors, which leave the world as it was: no such file, a damaged one, another program, scene or inputs.
Status read_saved_world(const Exec& exec, const std::filesystem::path& path, const Scene& scene,
                        const LoadedWorld& loaded, World& world, Measures& measures);

}  // namespace turgor
