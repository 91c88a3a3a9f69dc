// Reads [body.NAME] with model = "lattice": lattice::Params and input files.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

LatticeScene read_lattice_scene(SceneTable body, const std::string& name, Device device);

}  // namespace turgor
