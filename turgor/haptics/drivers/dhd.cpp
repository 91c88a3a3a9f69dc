#include "turgor/haptics/drivers/dhd.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/haptics/drivers/readings.hpp"

namespace turgor::haptics {

namespace {

constexpr unsigned char kWatchdog = 255;  // [0.125 ms]
constexpr int kCheckInterval = 32;        // exchanges between two checks of the arm's state
constexpr double kWideOpen = 0.52;        // angle of an open gripper [rad]
constexpr double kSmallForce = 0.2;       // force that may start at once [N]

/// Conversion between the vendor's frame (x towards the user, y right, z up) and the device frame (x right, y
/// away from the user, z up).
Vec3d to_device_frame(Vec3d v) { return {v.y, -v.x, v.z}; }
Vec3d to_vendor_frame(Vec3d v) { return {-v.y, v.x, v.z}; }

/// Conversion of a rotation matrix, given as rows. The grip's axes have the same names in both frames.
Mat3d to_device_frame(const double m[3][3]) {
  const auto column = [m](int j) { return to_device_frame(Vec3d{m[0][j], m[1][j], m[2][j]}); };
  return {{column(1), -column(0), column(2)}};
}

const char* cause_text(int cause) {
  switch (cause) {
    case kDhdByButton:
      return "by its button";
    case kDhdByVelocity:
      return "because it moved too fast";
    case kDhdByWatchdog:
      return "by its watchdog: no force was sent for 32 ms";
    case kDhdBySoftware:
      return "by a program";
    case kDhdByUsb:
      return "because it was disconnected";
    case kDhdByDeadman:
      return "by its dead-man switch";
    default:
      return "for an unknown reason";
  }
}

}  // namespace

Error Dhd::error(const std::string& what) const {
  const char* reason = dhd_.error_get_last_str ? dhd_.error_get_last_str() : nullptr;
  return {fmt::format("dhd: {}{}{}", what, reason ? ": " : "", reason ? on_one_line(reason) : "")};
}

Status Dhd::open() {
  close();
  // library and connected arms
  Result<DhdLibrary> library = load_dhd(options_.library);
  if (!library) return Error{"dhd: " + library.error().message};
  dhd_ = std::move(*library);
  if (dhd_.get_device_count() <= 0)
    return Error{
        "dhd: no arm is connected, or this user has no permission: check cable, power and the udev rule "
        "(docs/devices.md)"};
  // open, find the zero, prepare
  Status ready = open_arm();
  if (ready) ready = find_zero();
  if (ready) ready = prepare();
  if (!ready) close();
  return ready;
}

/// Opens the arm with drd if available, because only drd can find the zero. drd does not support all arms.
Status Dhd::open_arm() {
  // number of the arm
  int index = -1;
  const std::string& which = options_.which;
  const auto [end, wrong] = std::from_chars(which.data(), which.data() + which.size(), index);
  if (!which.empty() &&
      (wrong != std::errc() || end != which.data() + which.size() || index < 0 || index > 126))
    return Error{fmt::format("dhd: expected the number of an arm, 0 for the first, found \"{}\"", which)};
  // open with drd, otherwise with dhd
  int id = -1;
  if (dhd_.has_drd()) id = which.empty() ? dhd_.drd_open() : dhd_.drd_open_id(char(index));
  is_drd_ = id >= 0;
  if (id < 0) id = which.empty() ? dhd_.open() : dhd_.open_id(char(index));
  if (id < 0) return error("the arm cannot be opened; is another program using it?");
  id_ = char(id);
  is_open_ = true;
  return Done{};
}

Status Dhd::find_zero() {
  if (!is_drd_) return Done{};
  if (dhd_.drd_is_supported(id_) && !dhd_.drd_is_initialized(id_)) {
    if (!options_.may_move)
      return Error{
          "dhd: the arm has not found its zero yet. It moves by itself to find it: take your hand away and "
          "allow "
          "it (may_move), or run the vendor's HapticInit"};
    if (dhd_.drd_auto_init(id_) < 0) return error("the arm did not find its zero");
  }
  if (dhd_.drd_stop(true, id_) < 0) return error("the arm's automatic motion cannot be stopped");
  return Done{};
}

Status Dhd::prepare() {
  // specification
  spec_ = dhd_spec(dhd_.get_system_type(id_));
  const char* name = dhd_.get_system_name(id_);
  spec_.name = name ? on_one_line(name) : "Force Dimension arm";
  spec_.has_orientation = dhd_.has_wrist(id_);
  spec_.has_grip = dhd_.has_gripper(id_);
  if (!dhd_.has_active_wrist(id_)) spec_.torque = 0;
  if (!dhd_.has_active_gripper(id_)) spec_.grip_force = 0;
  // settings of the arm
  TURGOR_CHECK(spec_.force > 0 && spec_.rate > 0, "the specification of an arm has a force and a rate");
  (void)dhd_.set_gravity_compensation(1, id_);  // not all arms support it
  (void)dhd_.set_max_force(spec_.force, id_);
  if (dhd_.enable_expert_mode() >= 0) {  // for the watchdog only; the velocity threshold stays unchanged
    (void)dhd_.set_watchdog(kWatchdog, id_);
    (void)dhd_.disable_expert_mode();
  }
  // zero force, then switch forces on
  if (!send({})) return error("no force can be sent");
  if (dhd_.enable_force(1, id_) < 0) return error("forces cannot be switched on");
  exchanges_ = 0;
  condition_ = Condition::kGood;
  return Done{};
}

bool Dhd::send(const DeviceOutput& output) noexcept {
  TURGOR_CHECK(is_finite(output), "forces are finite before they go to a device");
  const Vec3d f = to_vendor_frame(output.force), t = to_vendor_frame(output.torque);
  return dhd_.set_force_and_torque_and_gripper_force(f.x, f.y, f.z, t.x, t.y, t.z, output.grip_force, id_) >=
         0;
}

bool Dhd::receive(DeviceInput& input) noexcept {
  Vec3d x, v, w;
  double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, angle = kWideOpen;
  // read
  const bool is_read =
      dhd_.get_position_and_orientation_frame(&x.x, &x.y, &x.z, frame, id_) >= 0 &&
      dhd_.get_linear_velocity(&v.x, &v.y, &v.z, id_) >= 0 &&
      (!spec_.has_orientation || dhd_.get_angular_velocity_rad(&w.x, &w.y, &w.z, id_) >= 0) &&
      (!spec_.has_grip || dhd_.get_gripper_angle_rad(&angle, id_) >= 0);
  if (!is_read) return false;
  // convert
  input.pose = {to_device_frame(x), spec_.has_orientation ? to_device_frame(frame) : Mat3d{}};
  input.velocity = to_device_frame(v);
  input.angular_velocity = to_device_frame(w);
  input.grip =
      std::clamp(1 - std::abs(angle) / kWideOpen, 0.0, 1.0);  // angles of left-handed arms are negative
  input.buttons = dhd_.get_button_mask(id_);
  input.time = steady_seconds();
  return true;
}

/// Checks the arm's status. Switches forces on again after the watchdog when the requested force is small.
Dhd::Condition Dhd::check_state(double wanted_force) noexcept {
  int status[kDhdStatusCount] = {};
  if (dhd_.get_status(status, id_) < 0) return Condition::kFailed;
  if (!status[kDhdConnected]) return Condition::kUnplugged;
  if (status[kDhdReset]) return Condition::kInReset;
  if (status[kDhdForce]) return Condition::kGood;
  cause_ = status[kDhdForceOffCause];
  const bool may_return = cause_ == kDhdByWatchdog && wanted_force < kSmallForce;
  return may_return && dhd_.enable_force(1, id_) >= 0 ? Condition::kGood : Condition::kForcesOff;
}

bool Dhd::fail(Condition condition) noexcept {
  if (condition == Condition::kFailed) failure_ = dhd_.error_get_last_str();
  condition_ = condition;
  (void)send({});
  return false;
}

bool Dhd::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  if (!is_open_) return false;
  const DeviceOutput sent = sendable_output(spec_, output);
  DeviceInput read;
  if (!send(sent) || !receive(read)) return fail(Condition::kFailed);
  if (!is_plausible(read)) return fail(Condition::kImplausible);
  if (condition_ != Condition::kGood || ++exchanges_ % kCheckInterval == 0)
    if (const Condition seen = check_state(norm(sent.force)); seen != Condition::kGood) return fail(seen);
  condition_ = Condition::kGood;
  input = read;
  return true;
}

void Dhd::close() noexcept {
  condition_ = Condition::kClosed;
  if (!is_open_) return;
  (void)send({});
  (void)dhd_.enable_force(0, id_);
  (void)(is_drd_ ? dhd_.drd_close(id_) : dhd_.close(id_));
  is_open_ = false;
}

std::string Dhd::trouble() const {
  switch (condition_.load()) {
    case Condition::kGood:
      return "";
    case Condition::kClosed:
      return "dhd: the device is not open";
    case Condition::kFailed: {
      const char* reason = failure_;
      return fmt::format("dhd: the arm does not answer: {}",
                         reason ? on_one_line(reason) : "no reason given");
    }
    case Condition::kUnplugged:
      return "dhd: the arm was disconnected";
    case Condition::kInReset:
      return "dhd: the arm has lost its calibration: put it in its rest position, or open it again";
    case Condition::kForcesOff:
      return fmt::format("dhd: the arm switched its forces off {}; switch them on at the arm",
                         cause_text(cause_));
    case Condition::kImplausible:
      return "dhd: the arm reports an implausible position or speed";
  }
  return "";
}

void list_dhd(const DeviceOptions& options, DeviceListing& listing) {
  const Result<DhdLibrary> dhd = load_dhd(options.library);
  if (!dhd) {
    listing.note = dhd.error().message;
    return;
  }
  const int count = std::clamp(dhd->get_device_count(), 0, 16);
  for (int index = 0; index < count; index++) listing.connected.push_back(std::to_string(index));
  listing.note = fmt::format("found {}{}", dhd->library.file(),
                             count == 0 ? "; no arm is connected, or the udev rule is missing" : "");
}

}  // namespace turgor::haptics
