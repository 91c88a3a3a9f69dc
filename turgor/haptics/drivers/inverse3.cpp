#include "turgor/haptics/drivers/inverse3.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/core/start_thread.hpp"
#include "turgor/haptics/drivers/inverse3_link.hpp"
#include "turgor/haptics/drivers/readings.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

constexpr double kPeriod = 0.0005;  // between two commands: a state is at most half a tick of 1 kHz old [s]
constexpr double kLate = 0.02;      // age from which answers are not used [s]
constexpr double kForceTimeout = 0.05;  // duration of a force without another exchange [s]
constexpr double kRetryInterval = 1;    // for requests of a missing service or arm [s]
constexpr double kTurnWindow = 0.01;    // over which the grip's rotation is measured [s]

DeviceSpec spec_of(const Inverse3Arm& arm, const std::string& id) {
  const double r = arm.type == "minverse" ? 0.04 : 0.10;  // range in Haply's tutorials [m]
  return {.name = on_one_line(fmt::format("Haply {} {}", arm.type, id)),
          .workspace_low = {-r, -r, -r},
          .workspace_high = {r, r, r},
          .force = 5,
          .stiffness = 1000,
          .damping = 3,
          .has_orientation = arm.has_grip};
}

std::string no_arm(const DeviceOptions& options, const std::vector<std::string>& ids) {
  if (ids.empty())
    return fmt::format("inverse3: the Inverse Service at {} reports no arm; connect it and switch it on",
                       options.address);
  return fmt::format("inverse3: the Inverse Service at {} reports the arms {}, not {}", options.address,
                     listed(ids), on_one_line(options.which));
}

/// Fault in the last answer; empty if none.
std::string fault_of(const DeviceOptions& options, const Inverse3Link& link) {
  if (!link.is_understood())
    return fmt::format("inverse3: the Inverse Service at {} sent an invalid message", options.address);
  if (!link.arm().is_allocated) return no_arm(options, link.ids());
  if (!link.arm().is_calibrated)
    return fmt::format(
        "inverse3: the arm {} is not calibrated; calibrate it as its lights and the Haply Hub show",
        on_one_line(link.id()));
  return "";
}

}  // namespace

Inverse3::Inverse3(const DeviceOptions& options) : options_(options) {}
Inverse3::~Inverse3() { close(); }

Status Inverse3::open() {
  close();
  stop_requested_ = false;
  link_ = std::make_unique<Inverse3Link>(options_.address, options_.which);
  Status ready = link_->connect(stop_requested_);
  ready = ready ? wait_for_arm() : Error{"inverse3: " + ready.error().message};
  if (!ready) return link_.reset(), set_trouble(ready.error().message), ready;
  spec_ = spec_of(link_->arm(), link_->id());
  wanted_.write({});
  publish();
  Result<std::thread> started = start_thread("the driver inverse3", [this] { serve(); });
  if (!started) return link_.reset(), set_trouble(started.error().message), started.error();
  thread_ = std::move(*started);
  return Done{};
}

Status Inverse3::wait_for_arm() {
  // until an arm is found, or options.patience has passed
  TURGOR_ASSERT(link_ != nullptr, "an arm is awaited on a link");
  const double end = steady_seconds() + options_.patience;
  for (int attempts = 0;; attempts++) {
    // found, or ambiguous
    if (link_->arm().is_allocated) return Done{};
    if (options_.which.empty() && link_->ids().size() > 1)
      return Error{
          fmt::format("inverse3: several arms are connected ({}); choose one", listed(link_->ids()))};
    // wait and request again
    const std::string fault = fault_of(options_, *link_);
    set_trouble(fault);
    if (steady_seconds() >= end)
      return Error{fmt::format("{}; asked {} times in {:g} s", fault, attempts, options_.patience)};
    pause(std::min(kRetryInterval, end - steady_seconds()));
    if (Status heard = link_->exchange_message({}, stop_requested_); !heard)
      return Error{"inverse3: " + heard.error().message};
  }
}

void Inverse3::serve() {
  for (double next = steady_seconds(); !stop_requested_;
       next = std::max(next + kPeriod, steady_seconds() - kPeriod)) {
    const Status served = serve_once();
    if (!served) set_trouble("inverse3: " + served.error().message);
    publish();
    const bool waits = !served || !link_->arm().is_allocated;
    if (waits && !stop_requested_) pause(kRetryInterval);
    pause(next + kPeriod - steady_seconds());
  }
  link_->disconnect();
}

/// Exchanges one command and its answer, or tries to connect.
Status Inverse3::serve_once() {
  if (!link_->is_connected()) return link_->connect(stop_requested_);
  const Wanted& wanted = wanted_.read();
  const bool holds = steady_seconds() - wanted.time < kForceTimeout;
  return link_->exchange_message(holds ? wanted.force : Vec3d{}, stop_requested_);
}

/// Publishes the arm's state for the haptic thread, and the fault for others.
void Inverse3::publish() {
  TURGOR_ASSERT(link_ != nullptr, "samples are published while the link exists");
  Sample sample;
  if (link_->is_connected()) {
    // input from the last answer
    const Inverse3Arm& arm = link_->arm();
    sample.input = {.pose = {arm.position, axes_of(arm.orientation)},
                    .velocity = arm.velocity,
                    .buttons = arm.buttons,
                    .time = steady_seconds()};
    measure_rotation(sample.input);
    // faults
    const bool is_plausible_input = is_plausible(sample.input);
    const std::string fault = fault_of(options_, *link_);
    sample.is_usable = is_plausible_input && fault.empty();
    answered_at_ = sample.input.time;
    set_trouble(fault.empty() && !is_plausible_input
                    ? "inverse3: the arm reports an implausible position or speed"
                    : fault);
  }
  sample_.write(sample);
}

/// Measures the grip's angular velocity, which the service does not report.
void Inverse3::measure_rotation(DeviceInput& input) {
  const double passed = input.time - measured_at_;
  if (passed >= kTurnWindow) {
    angular_velocity_ = passed < 2 * kTurnWindow
                            ? rotation_vector(input.pose.axes * transposed(last_axes_)) / passed
                            : Vec3d{};
    last_axes_ = input.pose.axes;
    measured_at_ = input.time;
  }
  input.angular_velocity = angular_velocity_;
}

bool Inverse3::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  const double now = steady_seconds();
  wanted_.write({sendable_output(spec_, output).force, now});
  const Sample& sample = sample_.read();
  if (!sample.is_usable || now - sample.input.time > kLate) return false;
  input = sample.input;
  return true;
}

void Inverse3::close() noexcept {
  stop_requested_ = true;
  if (thread_.joinable()) thread_.join();
  link_.reset();
  sample_.write({});
  try {
    set_trouble("inverse3: the device is not open");
  } catch (...) {  // no memory for the text
  }
}

std::string Inverse3::trouble() const {
  const std::lock_guard lock(mutex_);
  const double silent = steady_seconds() - answered_at_;
  if (!trouble_.empty() || silent <= kLate) return trouble_;
  return fmt::format("inverse3: the Inverse Service at {} has not answered for {:.3f} s", options_.address,
                     silent);
}

/// Sleeps in short intervals, so that close does not wait.
void Inverse3::pause(double seconds) const {
  constexpr double kPiece = 0.05;
  for (const double end = steady_seconds() + seconds; !stop_requested_ && steady_seconds() < end;)
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(kPiece, end - steady_seconds())));
}

void Inverse3::set_trouble(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  if (trouble_ != trouble) trouble_ = trouble;
}

void list_inverse3(const DeviceOptions& options, DeviceListing& listing) {
  const std::atomic<bool> stop_requested = false;
  Inverse3Link link(options.address, "");
  if (Status connected = link.connect(stop_requested); !connected) {
    listing.note = connected.error().message;
    return;
  }
  listing.connected = link.ids();
  listing.note = fmt::format("the Inverse Service at {} answers{}", options.address,
                             link.ids().empty() ? "; connect an arm and switch it on" : "");
  link.disconnect();
}

}  // namespace turgor::haptics
