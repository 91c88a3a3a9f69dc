// `turgor run --check`: cost and plausibility of a scene, before a full simulation.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// Loads the scene as a run does and steps a few frames. Prints its bodies and tools, plausibility warnings,
/// and the memory and time that a run will take. Writes no file. Failure: every reason for which a run would
/// refuse the scene.
void check_scene(const Exec& exec, const Scene& scene);

}  // namespace turgor
