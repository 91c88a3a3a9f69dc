#include "turgor/haptics/drivers/dhd_library.hpp"

#include <string>
#include <vector>

#include <fmt/format.h>

namespace turgor::haptics {

namespace {

std::vector<std::string> dhd_candidates(const std::filesystem::path& file) {
  if (!file.empty()) return {file.string()};
  // folders of the SDK and of the user
  std::vector<std::string> folders;
  for (const char* name : {"FDSDK", "FORCEDIM_SDK"})
    if (const std::string sdk = environment(name); !sdk.empty())
      folders.insert(folders.end(), {sdk + "/lib/release/lin-x86_64-gcc", sdk + "/lib", sdk});
  if (const std::string home = environment("HOME"); !home.empty()) folders.push_back(home + "/.local/lib");
  folders.push_back("/usr/local/lib");
  // libraries, drd first
  std::vector<std::string> files;
  for (const char* stem : {"libdrd.so", "libdhd.so"}) {
    for (const std::string& folder : folders)
      for (const std::string& found : library_files(folder, stem)) files.push_back(found);
    files.insert(files.end(), {stem, stem + std::string(".3")});
  }
  return files;
}

/// First function that the library lacks, or null.
const char* missing_function(DhdLibrary& l) {
  const char* missing = nullptr;
  const auto bind = [&](const char* symbol, auto*& function) {
    if (!l.library.bind(symbol, function) && !missing) missing = symbol;
  };
  bind("dhdGetDeviceCount", l.get_device_count);
  bind("dhdOpen", l.open);
  bind("dhdOpenID", l.open_id);
  bind("dhdClose", l.close);
  bind("dhdGetSystemType", l.get_system_type);
  bind("dhdGetSystemName", l.get_system_name);
  bind("dhdHasWrist", l.has_wrist);
  bind("dhdHasActiveWrist", l.has_active_wrist);
  bind("dhdHasGripper", l.has_gripper);
  bind("dhdHasActiveGripper", l.has_active_gripper);
  bind("dhdEnableForce", l.enable_force);
  bind("dhdSetGravityCompensation", l.set_gravity_compensation);
  bind("dhdSetMaxForce", l.set_max_force);
  bind("dhdEnableExpertMode", l.enable_expert_mode);
  bind("dhdDisableExpertMode", l.disable_expert_mode);
  bind("dhdSetWatchdog", l.set_watchdog);
  bind("dhdSetForceAndTorqueAndGripperForce", l.set_force_and_torque_and_gripper_force);
  bind("dhdGetPositionAndOrientationFrame", l.get_position_and_orientation_frame);
  bind("dhdGetLinearVelocity", l.get_linear_velocity);
  bind("dhdGetAngularVelocityRad", l.get_angular_velocity_rad);
  bind("dhdGetGripperAngleRad", l.get_gripper_angle_rad);
  bind("dhdGetButtonMask", l.get_button_mask);
  bind("dhdGetStatus", l.get_status);
  bind("dhdErrorGetLast", l.error_get_last);
  bind("dhdErrorGetLastStr", l.error_get_last_str);
  return missing;
}

void bind_drd(DhdLibrary& l) {
  const SharedLibrary& from = l.library;
  const bool all = from.bind("drdOpen", l.drd_open) && from.bind("drdOpenID", l.drd_open_id) &&
                   from.bind("drdClose", l.drd_close) && from.bind("drdIsSupported", l.drd_is_supported) &&
                   from.bind("drdIsInitialized", l.drd_is_initialized) &&
                   from.bind("drdAutoInit", l.drd_auto_init);
  if (all) from.bind("drdStop", l.drd_stop);
}

}  // namespace

Result<DhdLibrary> load_dhd(const std::filesystem::path& file) {
  Result<SharedLibrary> library = SharedLibrary::open(dhd_candidates(file));
  if (!library)
    return Error{
        fmt::format("{}; install the Force Dimension SDK and set FDSDK to its folder (docs/devices.md)",
                    library.error().message)};
  DhdLibrary dhd{.library = std::move(*library)};
  if (const char* missing = missing_function(dhd))
    return Error{fmt::format("{}: lacks the function {}; expected the Force Dimension SDK 3.14 or later",
                             dhd.library.file(), missing)};
  bind_drd(dhd);
  return dhd;
}

}  // namespace turgor::haptics
