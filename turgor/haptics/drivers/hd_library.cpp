#include "turgor/haptics/drivers/hd_library.hpp"

#include <string>
#include <vector>

#include <fmt/format.h>

namespace turgor::haptics {

namespace {

std::vector<std::string> hd_candidates(const std::filesystem::path& file) {
  if (!file.empty()) return {file.string()};
  std::vector<std::string> files;
  for (const char* version : {"", ".3", ".3.5", ".3.4", ".3.0"})
    files.push_back(std::string("libHD.so") + version);
  for (const char* folder : {"/usr/lib", "/usr/local/lib", "/usr/lib64"})
    for (const std::string& found : library_files(folder, "libHD.so")) files.push_back(found);
  return files;
}

/// First function that the library lacks, or null.
const char* missing_function(HdLibrary& l) {
  const char* missing = nullptr;
  const auto bind = [&](const char* symbol, auto*& function) {
    if (!l.library.bind(symbol, function) && !missing) missing = symbol;
  };
  bind("hdInitDevice", l.init_device);
  bind("hdDisableDevice", l.disable_device);
  bind("hdMakeCurrentDevice", l.make_current_device);
  bind("hdBeginFrame", l.begin_frame);
  bind("hdEndFrame", l.end_frame);
  bind("hdGetError", l.get_error);
  bind("hdEnable", l.enable);
  bind("hdDisable", l.disable);
  bind("hdGetIntegerv", l.get_integers);
  bind("hdGetDoublev", l.get_doubles);
  bind("hdSetDoublev", l.set_doubles);
  bind("hdGetString", l.get_string);
  bind("hdCheckCalibration", l.check_calibration);
  bind("hdUpdateCalibration", l.update_calibration);
  bind("hdStartScheduler", l.start_scheduler);
  bind("hdStopScheduler", l.stop_scheduler);
  bind("hdScheduleAsynchronous", l.schedule_asynchronous);
  bind("hdUnschedule", l.unschedule);
  return missing;
}

}  // namespace

Result<HdLibrary> load_hd(const std::filesystem::path& file) {
  Result<SharedLibrary> library = SharedLibrary::open(hd_candidates(file));
  if (!library)
    return Error{
        fmt::format("{}; install 3D Systems OpenHaptics and the driver of the device (docs/devices.md)",
                    library.error().message)};
  HdLibrary hd{.library = std::move(*library)};
  if (const char* missing = missing_function(hd))
    return Error{fmt::format("{}: lacks the function {}; expected OpenHaptics 3.0 or later",
                             hd.library.file(), missing)};
  return hd;
}

const char* hd_error_text(unsigned code) {
  switch (code) {
    case hd::kForceFault:
      return "forces are switched off";
    case hd::kDeviceFault:
      return "the device reports a fault";
    case hd::kInUse:
      return "another program uses the device";
    case hd::kNoConnection:
      return "the device does not answer: check cable and power";
    case hd::kBadConfiguration:
      return "the device is not set up: run the vendor's Touch Setup";
    case hd::kTimerFault:
      return "the vendor's clock failed";
    case hd::kNoLicense:
      return "the vendor's library found no license";
    default:
      return "the vendor's library reports an error";
  }
}

}  // namespace turgor::haptics
