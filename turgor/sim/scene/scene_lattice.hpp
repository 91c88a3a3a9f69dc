// [body.NAME] of a scene, when its model is "lattice": from TOML to lattice::Params and the files it is built
// from.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

LatticeScene read_lattice_scene(SceneTable body, const std::string& name, Device device);

}  // namespace turgor
