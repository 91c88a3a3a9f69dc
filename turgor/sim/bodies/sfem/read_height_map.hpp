// Reads the heights of a textured surface.
#pragma once

#include <memory>

#include "turgor/contact/height_map.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Map of the scene's file; null without one. Error: file and line of a row that has another length or is no
/// row of numbers, more than 4 million samples, or heights beyond 1 mm of their mean.
Result<std::shared_ptr<const contact::HeightMap>> read_height_map(const HeightMapScene& scene);

}  // namespace turgor
