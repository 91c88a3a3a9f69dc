// Haptic devices by name, with the limits that programs for them use: the forces a scene may render on each.
// The numbers are those of the open-source framework CHAI3D and of the drivers' table (docs/devices.md).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace turgor::haptics {

/// Limits of a device. A limit of 0 is unknown.
struct DevicePreset {
  const char *name, *title;
  double force;      // largest, in any direction [N]
  double stiffness;  // largest that feels rigid [N/m]
  double damping;    // [N·s/m]
  double radius;     // of the workspace, about its center [m]
};

std::span<const DevicePreset> device_presets();
/// Null for an unknown name.
const DevicePreset* find_device_preset(std::string_view name);
/// "delta.3, falcon, …"
std::string device_preset_names();

}  // namespace turgor::haptics
