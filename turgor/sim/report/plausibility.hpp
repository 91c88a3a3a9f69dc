// What a person would doubt on seeing it: bodies as large as houses, tools larger than what they touch, cloth
// pulled to rags, contact that presses harder than the tissue's law knows. Sentences for the report.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/pressed.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Bodies and tools of a size that tissue does not have: mostly millimetres taken for metres.
std::vector<std::string> odd_sizes(const WorldSnapshot& snapshot);

/// The longest that the edges of one cloth became, as a multiple of their length at rest.
struct ClothStretch {
  std::string body;
  double most = 1;  // [1]
  double time = 0;  // [s]
};
/// Looks at the cloth of one moment; what it saw before stays in `seen`.
void note_stretch(const WorldSnapshot& snapshot, std::vector<ClothStretch>& seen);
std::vector<std::string> overstretched(const std::vector<ClothStretch>& seen);

/// Bodies of elements that were pressed harder than their law can answer.
std::vector<std::string> overpressed(const World& world, const std::vector<Pressed>& pressed);

}  // namespace turgor
