// Plausibility checks of a run: sizes of bodies and tools, stretch of cloth, contact pressure. Each warning
// is a sentence.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/pressed.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Implausible sizes of bodies and tools, mostly from millimeters read as meters.
std::vector<std::string> odd_sizes(const WorldSnapshot& snapshot);

/// Largest edge stretch of one cloth, relative to its rest length.
struct ClothStretch {
  std::string body;
  double most = 1;  // [1]
  double time = 0;  // [s]
};
/// Updates the largest stretches from one snapshot.
void record_stretch(const WorldSnapshot& snapshot, std::vector<ClothStretch>& seen);
std::vector<std::string> overstretched(const std::vector<ClothStretch>& seen);

/// Bodies of finite elements whose contact pressure exceeds Young's modulus.
std::vector<std::string> overpressed(const World& world, const std::vector<Pressed>& pressed);

/// Bodies of finite elements that are strained beyond their law: linear ones beyond kLinearStrain, nonlinear
/// ones beside the border of their patch, or solved less than a hundred times a second.
std::vector<std::string> overstrained(const World& world);

}  // namespace turgor
