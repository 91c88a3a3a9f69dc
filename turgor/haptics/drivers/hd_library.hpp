// Run-time binding of 3D Systems' OpenHaptics device library (HDAPI, 3.0 and later): the functions and
// constants in use, as its documentation declares them. Millimeters, newtons, radians; x to the right, y up,
// z towards the user.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"
#include "turgor/haptics/drivers/shared_library.hpp"

namespace turgor::haptics {

struct HdError {
  unsigned code;
  int internal;
  unsigned handle;
};
using HdCallback = unsigned (*)(void* context);

namespace hd {

constexpr unsigned kNoHandle = 0xffffffff;
constexpr unsigned kDone = 0, kContinue = 1;  // return values of a callback
constexpr unsigned short kHighestPriority = 65535;

// Parameters that can be read and set.
constexpr unsigned kButtons = 0x2000, kVelocity = 0x2051, kTransform = 0x2052, kAngularVelocity = 0x2053;
constexpr unsigned kModel = 0x2501, kSerial = 0x2504, kWorkspace = 0x2551, kCalibrationStyle = 0x2555;
constexpr unsigned kMaxStiffness = 0x2602, kMaxForce = 0x2603, kMaxDamping = 0x2609, kForce = 0x2700;

// Capabilities.
constexpr unsigned kForceOutput = 0x4000, kForceClamping = 0x4001, kForceRamping = 0x4002;

// Calibration: states and methods.
constexpr unsigned kCalibrated = 0x5000, kNeedsUpdate = 0x5001, kNeedsHand = 0x5002;
constexpr int kAutomatic = 2, kInkwell = 4;

// Errors. Codes from kWarmMotors to kTooFast are warnings.
constexpr unsigned kWarmMotors = 0x200, kTooMuchForce = 0x201, kTooMuchImpulse = 0x202, kTooFast = 0x203;
constexpr unsigned kForceFault = 0x204, kDeviceFault = 0x300, kInUse = 0x301, kNoConnection = 0x302,
                   kBadConfiguration = 0x303, kTimerFault = 0x304, kNoLicense = 0x600;

}  // namespace hd

struct HdLibrary {
  SharedLibrary library;

  unsigned (*init_device)(const char* name);
  void (*disable_device)(unsigned handle);
  void (*make_current_device)(unsigned handle);
  void (*begin_frame)(unsigned handle);
  void (*end_frame)(unsigned handle);
  HdError (*get_error)();
  void (*enable)(unsigned capability);
  void (*disable)(unsigned capability);
  void (*get_integers)(unsigned parameter, int* values);
  void (*get_doubles)(unsigned parameter, double* values);
  void (*set_doubles)(unsigned parameter, const double* values);
  const char* (*get_string)(unsigned parameter);
  unsigned (*check_calibration)();
  void (*update_calibration)(unsigned style);
  void (*start_scheduler)();
  void (*stop_scheduler)();
  unsigned long (*schedule_asynchronous)(HdCallback callback, void* context, unsigned short priority);
  void (*unschedule)(unsigned long handle);
};

/// Loads `file` if it is not empty, otherwise libHD.so from the loader's search path. Error: the loader's
/// message and what to install, or the name of a missing function.
Result<HdLibrary> load_hd(const std::filesystem::path& file);

/// Meaning of an error code.
const char* hd_error_text(unsigned code);

}  // namespace turgor::haptics
