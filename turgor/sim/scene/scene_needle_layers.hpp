// Reads `inside` of a lattice body: layers and regions with a resistance of their own to needles.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Reads `hu`, a range of CT values.
void read_hu_range(SceneTable& table, std::optional<std::array<double, 2>>& hu);
/// True if two ranges have values in common.
inline bool overlap(const std::optional<std::array<double, 2>>& a,
                    const std::optional<std::array<double, 2>>& b) {
  return a && b && (*a)[0] < (*b)[1] && (*b)[0] < (*a)[1];
}

/// `has_labels`: the body has a segmentation, or a phantom's.
std::vector<NeedleLayerScene> read_needle_layers(SceneTable& body, bool has_labels, SceneLabels& labels);

}  // namespace turgor
