// Run-time binding of Force Dimension's SDK (3.17): the functions in use, as its documentation declares them.
// Failures return less than zero. An id of -1 means the default arm. Meters, newtons, radians; x towards the
// user, y to the right, z up.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"
#include "turgor/haptics/drivers/shared_library.hpp"

namespace turgor::haptics {

/// Entries of dhdGetStatus that are in use.
enum DhdStatus {
  kDhdConnected = 1,
  kDhdReset = 3,
  kDhdForce = 5,
  kDhdForceOffCause = 14,
  kDhdStatusCount = 17
};
/// Reasons for which forces are off.
enum DhdForceOff {
  kDhdByButton = 1,
  kDhdByVelocity,
  kDhdByWatchdog,
  kDhdBySoftware,
  kDhdByUsb,
  kDhdByDeadman
};

struct DhdLibrary {
  SharedLibrary library;

  int (*get_device_count)();
  int (*open)();
  int (*open_id)(char id);
  int (*close)(char id);
  int (*get_system_type)(char id);
  const char* (*get_system_name)(char id);
  bool (*has_wrist)(char id);
  bool (*has_active_wrist)(char id);
  bool (*has_gripper)(char id);
  bool (*has_active_gripper)(char id);
  int (*enable_force)(unsigned char on, char id);
  int (*set_gravity_compensation)(int on, char id);
  int (*set_max_force)(double newtons, char id);
  int (*enable_expert_mode)();
  int (*disable_expert_mode)();
  int (*set_watchdog)(unsigned char eighths_of_ms, char id);
  int (*set_force_and_torque_and_gripper_force)(double fx, double fy, double fz, double tx, double ty,
                                                double tz, double fg, char id);
  int (*get_position_and_orientation_frame)(double* x, double* y, double* z, double m[3][3], char id);
  int (*get_linear_velocity)(double* x, double* y, double* z, char id);
  int (*get_angular_velocity_rad)(double* x, double* y, double* z, char id);
  int (*get_gripper_angle_rad)(double* angle, char id);
  unsigned (*get_button_mask)(char id);
  int (*get_status)(int status[kDhdStatusCount], char id);
  int (*error_get_last)();
  const char* (*error_get_last_str)();

  // Functions of libdrd only, which can move an arm to find its zero. Null with libdhd.
  int (*drd_open)() = nullptr;
  int (*drd_open_id)(char id) = nullptr;
  int (*drd_close)(char id) = nullptr;
  bool (*drd_is_supported)(char id) = nullptr;
  bool (*drd_is_initialized)(char id) = nullptr;
  int (*drd_auto_init)(char id) = nullptr;
  int (*drd_stop)(bool keeps_forces, char id) = nullptr;
  bool has_drd() const { return drd_stop != nullptr; }
};

/// Loads `file` if it is not empty. Otherwise loads libdrd or libdhd from $FDSDK, $FORCEDIM_SDK,
/// ~/.local/lib, /usr/local/lib or the loader's search path, the highest version first. Error: the loader's
/// message and what to install, or the name of a missing function.
Result<DhdLibrary> load_dhd(const std::filesystem::path& file);

}  // namespace turgor::haptics
