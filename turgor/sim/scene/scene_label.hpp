// Reading a label of a segmentation from a scene.
#pragma once

#include <string>

#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// A label by number or by name, from a number or a text.
void read_label(SceneTable& table, const std::string& key, int& label);

}  // namespace turgor
