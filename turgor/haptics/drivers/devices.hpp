// Registry of haptic drivers: list of drivers, detection of connected devices, and opening of a device. A
// driver loads its vendor's library or contacts its service at run time. No vendor software is needed to
// build.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// Options of all drivers; each driver reads its own ones.
struct DeviceOptions {
  std::string which;  // among several devices, as list_devices names it; empty = the only one
  std::string address = "localhost:10001";  // of the Inverse Service
  std::filesystem::path library;            // of the vendor; empty = the default search path
  std::filesystem::path file;               // of poses to replay
  double patience = 5;    // time to wait for a device that is not connected or not calibrated [s]
  bool may_move = false;  // the arm may move by itself to find its zero; nothing may be in its path
};

/// Result of a driver's search.
struct DeviceListing {
  std::string driver;                  // name for open_device
  std::string devices;                 // supported devices
  std::vector<std::string> connected;  // each in the form of DeviceOptions::which
  std::string note;                    // missing software and how to install it, or the result
};

/// Opens a device. Error: unknown driver, or the error of its open().
Result<std::unique_ptr<Device>> open_device(const std::string& driver, const DeviceOptions& options = {});

/// Listings of all drivers. Moves nothing, opens no arm, and takes at most two seconds.
std::vector<DeviceListing> list_devices(const DeviceOptions& options = {});

}  // namespace turgor::haptics
