// Reads `ct` of a scene, or a phantom such as { phantom = "torso" }.
#pragma once

#include "turgor/sim/scene/ct_source.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

PhantomParams read_phantom(SceneTable table);
/// The keys `ct` and `series`.
CtSource read_ct_source(SceneTable& table);

}  // namespace turgor
