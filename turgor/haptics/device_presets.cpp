#include "turgor/haptics/device_presets.hpp"

#include <algorithm>
#include <iterator>

namespace turgor::haptics {

namespace {

constexpr DevicePreset kPresets[] = {
    {"delta.3", "Force Dimension delta.3", 20, 5000, 30, 0.15},
    {"falcon", "Novint Falcon", 8, 3000, 20, 0.04},
    {"inverse3", "Haply Inverse3", 5, 1000, 3, 0.10},
    {"lambda.7", "Force Dimension lambda.7", 12, 8000, 0, 0.11},
    {"omega.3", "Force Dimension omega.3", 12, 5000, 0, 0.075},
    {"premium-1.5", "3D Systems Phantom Premium 1.5", 8.5, 800, 0, 0},
    {"sigma.7", "Force Dimension sigma.7", 12, 4000, 0, 0},
    {"touch", "3D Systems Touch", 3.3, 400, 4, 0},
};

}  // namespace

std::span<const DevicePreset> device_presets() { return kPresets; }

const DevicePreset* find_device_preset(std::string_view name) {
  const auto found = std::find_if(std::begin(kPresets), std::end(kPresets),
                                  [&](const DevicePreset& preset) { return name == preset.name; });
  return found == std::end(kPresets) ? nullptr : &*found;
}

std::string device_preset_names() {
  std::string names;
  for (const DevicePreset& preset : kPresets) names += (names.empty() ? "" : ", ") + std::string(preset.name);
  return names;
}

}  // namespace turgor::haptics
