#include "turgor/haptics/drivers/openhaptics.hpp"

#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/haptics/drivers/readings.hpp"

namespace turgor::haptics {

namespace {

constexpr double kMillimeter = 1e-3;  // [m]

/// Conversion between the vendor's frame (x right, y up, z towards the user) and the device frame (x right, y
/// away from the user, z up).
Vec3d hd_to_device_frame(Vec3d v) { return {v.x, -v.z, v.y}; }
Vec3d device_to_hd_frame(Vec3d v) { return {v.x, v.z, -v.y}; }

void sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

Error error(unsigned code, const char* when) {
  return {fmt::format("openhaptics: {}: {} (HD error {:#x})", when, hd_error_text(code), code)};
}

}  // namespace

Status OpenHaptics::open() {
  close();
  // library
  Result<HdLibrary> library = load_hd(options_.library);
  if (!library) return Error{"openhaptics: " + library.error().message};
  hd_ = std::move(*library);
  // device
  clear_errors();
  handle_ = hd_.init_device(options_.which.empty() ? nullptr : options_.which.c_str());
  if (const unsigned code = hd_.get_error().code; code != 0 || handle_ == hd::kNoHandle)
    return close(), error(code, "the device cannot be opened");
  hd_.make_current_device(handle_);
  // calibration and specification
  Status ready = calibrate();
  if (ready) ready = describe();
  if (!ready) return close(), ready;
  stage_ = Stage::kReady;
  return Done{};
}

/// Calibrates the device. Encoders that must be zeroed by hand are left to the vendor's program, because a
/// wrong position would shift all later readings.
Status OpenHaptics::calibrate() {
  for (const double end = steady_seconds() + options_.patience;; sleep(0.1)) {
    // automatic methods
    unsigned state = hd_.check_calibration();
    int styles = 0;
    hd_.get_integers(hd::kCalibrationStyle, &styles);
    if (state == hd::kNeedsUpdate && (styles & (hd::kAutomatic | hd::kInkwell))) {
      hd_.update_calibration(styles & hd::kAutomatic ? hd::kAutomatic : hd::kInkwell);
      state = hd_.check_calibration();
    }
    clear_errors();
    // result, or wait
    if (state == hd::kCalibrated) return Done{};
    if (steady_seconds() < end) continue;
    return Error{
        state == hd::kNeedsHand
            ? "openhaptics: the device is not calibrated: put its stylus into the inkwell"
            : "openhaptics: the device is not calibrated: run the vendor's Touch Setup or Diagnostic"};
  }
}

Status OpenHaptics::describe() {
  // read and check the limits
  double force = 0, stiffness = 0, damping = 0, box[6] = {};
  hd_.get_doubles(hd::kMaxForce, &force);
  hd_.get_doubles(hd::kMaxStiffness, &stiffness);  // [N/mm]
  hd_.get_doubles(hd::kMaxDamping, &damping);      // [N·s/mm]
  hd_.get_doubles(hd::kWorkspace, box);            // lowest corner, highest corner [mm]
  if (const unsigned code = hd_.get_error().code; code != 0)
    return error(code, "the device's limits cannot be read");
  if (!(force > 0 && force < 100) || !(stiffness > 0 && stiffness < 100))
    return Error{
        fmt::format("openhaptics: expected a largest force below 100 N and a stiffness below 100 N/mm, "
                    "found {} and {}",
                    force, stiffness)};
  // specification
  const char* model = hd_.get_string(hd::kModel);
  const char* serial = hd_.get_string(hd::kSerial);
  const Vec3d low = hd_to_device_frame({box[0], box[1], box[2]}),
              high = hd_to_device_frame({box[3], box[4], box[5]});
  spec_ = {
      .name = on_one_line(fmt::format("{} {}", model ? model : "3D Systems device", serial ? serial : "")),
      .workspace_low = min(low, high) * kMillimeter,
      .workspace_high = max(low, high) * kMillimeter,
      .force = force,
      .stiffness = stiffness / kMillimeter,
      .damping = damping / kMillimeter,
      .has_orientation = true};
  return Done{};
}

Status OpenHaptics::start(DeviceTick tick, void* context) {
  TURGOR_ASSERT(stage_ == Stage::kReady, "a device is started once, after it was opened");
  // callback and force settings
  TURGOR_ASSERT(tick != nullptr, "a device calls a tick");
  tick_ = tick;
  context_ = context;
  has_ended_ = false;
  hd_.enable(hd::kForceOutput);
  hd_.enable(hd::kForceClamping);
  hd_.enable(hd::kForceRamping);
  // start the scheduler
  stage_ = Stage::kRunning;
  callback_ = hd_.schedule_asynchronous(call, this, hd::kHighestPriority);
  is_scheduled_ = true;
  hd_.start_scheduler();
  // Warnings are counted in ticks. Any other error prevents the start.
  if (const unsigned code = hd_.get_error().code;
      code != 0 && (code < hd::kWarmMotors || code > hd::kTooFast))
    return close(), error(code, "the haptic thread cannot be started");
  return Done{};
}

unsigned OpenHaptics::call(void* self) { return static_cast<OpenHaptics*>(self)->run_tick(); }

unsigned OpenHaptics::run_tick() noexcept {
  // read, tick, write
  DeviceInput input;
  DeviceOutput output;
  hd_.make_current_device(handle_);
  hd_.begin_frame(handle_);
  const bool is_running = stage_ == Stage::kRunning;
  if (is_running && !read(input))
    implausible_++;
  else if (is_running)
    tick_(context_, input, output);
  set_force(sendable_output(spec_, output).force);
  hd_.end_frame(handle_);
  // errors end the ticks
  if (!read_errors()) {
    Stage running = Stage::kRunning;
    stage_.compare_exchange_strong(running, Stage::kLost);
  }
  if (stage_ == Stage::kRunning) return hd::kContinue;
  if (is_running) {  // the force of this tick must not remain
    hd_.begin_frame(handle_);
    set_force({});
    hd_.end_frame(handle_);
  }
  has_ended_ = true;
  return hd::kDone;
}

bool OpenHaptics::read(DeviceInput& input) const noexcept {
  double m[16] = {}, v[3] = {}, w[3] = {};  // column-major, the position in the last column
  // read
  int buttons = 0;
  hd_.get_doubles(hd::kTransform, m);
  hd_.get_doubles(hd::kVelocity, v);
  hd_.get_doubles(hd::kAngularVelocity, w);
  hd_.get_integers(hd::kButtons, &buttons);
  // convert
  const auto column = [&](int c) { return hd_to_device_frame(Vec3d{m[4 * c], m[4 * c + 1], m[4 * c + 2]}); };
  input = {.pose = {column(3) * kMillimeter, {{column(0), -column(2), column(1)}}},
           .velocity = hd_to_device_frame(Vec3d{v[0], v[1], v[2]}) * kMillimeter,
           .angular_velocity = hd_to_device_frame(Vec3d{w[0], w[1], w[2]}),
           .buttons = std::uint32_t(buttons),
           .time = steady_seconds()};
  return is_plausible(input);
}

void OpenHaptics::set_force(Vec3d force) const noexcept {
  TURGOR_CHECK(std::isfinite(dot(force, force)), "forces are finite before they go to a device");
  const Vec3d f = device_to_hd_frame(force);
  const double newtons[3] = {f.x, f.y, f.z};
  hd_.set_doubles(hd::kForce, newtons);
}

/// Reads the queued errors. False when one of them is not a warning.
bool OpenHaptics::read_errors() noexcept {
  constexpr int kMaxErrors = 16;  // a tick
  for (int n = 0; n < kMaxErrors; n++) {
    const unsigned code = hd_.get_error().code;
    if (code == 0) return true;
    const bool is_warning = code >= hd::kWarmMotors && code <= hd::kTooFast;
    if (is_warning) warnings_[code - hd::kWarmMotors]++;
    if (!is_warning) return error_ = code, false;
  }
  return true;
}

void OpenHaptics::clear_errors() const {
  for (int n = 0; n < 100 && hd_.get_error().code != 0; n++) continue;
}

void OpenHaptics::close() noexcept {
  // wait for the last tick, then stop the scheduler
  if (is_scheduled_) {
    Stage running = Stage::kRunning;
    stage_.compare_exchange_strong(running, Stage::kEnding);
    for (const double end = steady_seconds() + 0.05; !has_ended_ && steady_seconds() < end;) sleep(0.001);
    hd_.stop_scheduler();
    hd_.unschedule(callback_);
    is_scheduled_ = false;
  }
  // zero force, then release the device
  if (handle_ != hd::kNoHandle) {
    hd_.make_current_device(handle_);
    hd_.begin_frame(handle_);
    set_force({});
    hd_.end_frame(handle_);
    hd_.disable(hd::kForceOutput);
    hd_.disable_device(handle_);
    handle_ = hd::kNoHandle;
  }
  stage_ = Stage::kClosed;
}

std::string OpenHaptics::trouble() const {
  const Stage stage = stage_;
  if (stage == Stage::kLost) return error(error_, "the device is lost").message;
  return stage == Stage::kReady || stage == Stage::kRunning ? "" : "openhaptics: the device is not open";
}

std::string OpenHaptics::remarks() const {
  constexpr const char* kNames[] = {"warm motors", "force above the limit", "impulse above the limit",
                                    "speed above the limit"};
  std::string text;
  const auto add = [&](int count, const char* name) {
    if (count > 0) text += fmt::format("{}{} ({} ticks)", text.empty() ? "openhaptics: " : ", ", name, count);
  };
  for (std::size_t n = 0; n < warnings_.size(); n++) add(warnings_[n], kNames[n]);
  add(implausible_, "implausible position or speed");
  return text;
}

void list_openhaptics(const DeviceOptions& options, DeviceListing& listing) {
  const Result<HdLibrary> hd = load_hd(options.library);
  listing.note = hd ? fmt::format("found {}; a device is detected only when it is opened", hd->library.file())
                    : hd.error().message;
}

}  // namespace turgor::haptics
