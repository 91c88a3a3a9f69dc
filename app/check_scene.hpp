// `turgor run --check`: what a scene would take, before anything is simulated to its end.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// Loads the scene as a run does, tries a few frames, and prints what it has, what doubts there are, and how
/// much memory and time a run will take. Writes no file. Failure: whatever a run would refuse.
void check_scene(const Exec& exec, const Scene& scene);

}  // namespace turgor
