// Which haptic devices Turgor drives, what is connected, and how one is opened. A driver finds its vendor's
// library or service when it is asked to: nothing of a vendor is needed to build.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// What drivers may want to know; each reads what concerns it.
struct DeviceOptions {
  std::string which;                        // of several: as list_devices names it; empty = the only one
  std::string address = "localhost:10001";  // of the Inverse Service
  std::filesystem::path library;            // of the vendor; empty = where such libraries are
  std::filesystem::path file;               // of poses to replay
  double patience = 5;    // how long a device that is not connected, or not calibrated, is waited for [s]
  bool may_move = false;  // the arm may move by itself to find its zero: no hand and nothing else in its way
};

/// What a driver sees.
struct DeviceListing {
  std::string driver;                  // its name, for open_device
  std::string devices;                 // what it drives
  std::vector<std::string> connected;  // each as DeviceOptions::which takes it
  std::string note;                    // what is missing and what to install, or what was found
};

/// An open device. Error: no such driver, or what its open says.
Result<std::unique_ptr<Device>> open_device(const std::string& driver, const DeviceOptions& options = {});

/// Of every driver. Moves nothing, opens no arm, and takes no longer than two seconds.
std::vector<DeviceListing> list_devices(const DeviceOptions& options = {});

}  // namespace turgor::haptics
