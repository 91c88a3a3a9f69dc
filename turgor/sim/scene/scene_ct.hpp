// `ct = …` in a scene, and { phantom = "torso", … }: a synthetic patient in place of a file.
#pragma once

#include "turgor/sim/scene/ct_source.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

PhantomParams read_phantom(SceneTable table);
/// The keys `ct` and `series`.
CtSource read_ct_source(SceneTable& table);

}  // namespace turgor
