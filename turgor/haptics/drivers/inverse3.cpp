#include "turgor/haptics/drivers/inverse3.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "turgor/core/one_line.hpp"
#include "turgor/haptics/drivers/inverse3_link.hpp"
#include "turgor/haptics/drivers/readings.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

constexpr double kPeriod = 0.0005;  // between two commands: a state is no older than half a tick of 1 kHz [s]
constexpr double kLate = 0.02;      // older answers are not used [s]
constexpr double kForgotten = 0.05;   // a force is held no longer without another exchange [s]
constexpr double kAskAgain = 1;       // for a service or an arm that is not there [s]
constexpr double kTurnWindow = 0.01;  // over which the grip's turning is measured [s]

DeviceSpec spec_of(const Inverse3Arm& arm, const std::string& id) {
  const double r = arm.type == "minverse" ? 0.04 : 0.10;  // that Haply's tutorials keep to [m]
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
    return fmt::format("inverse3: the Inverse Service at {} knows no arm; connect it and switch it on",
                       options.address);
  return fmt::format("inverse3: the Inverse Service at {} knows the arms {}, not {}", options.address,
                     listed(ids), on_one_line(options.which));
}

/// Of what was heard last; empty when nothing is wrong.
std::string fault_of(const DeviceOptions& options, const Inverse3Link& link) {
  if (!link.is_understood())
    return fmt::format("inverse3: what the Inverse Service at {} says makes no sense", options.address);
  if (!link.arm().is_allocated) return no_arm(options, link.ids());
  if (!link.arm().is_calibrated)
    return fmt::format("inverse3: the arm {} is not calibrated; do it as its lights and the Haply Hub say",
                       on_one_line(link.id()));
  return "";
}

}  // namespace

Inverse3::Inverse3(const DeviceOptions& options) : options_(options) {}
Inverse3::~Inverse3() { close(); }

Status Inverse3::open() {
  close();
  stops_ = false;
  link_ = std::make_unique<Inverse3Link>(options_.address, options_.which);
  Status ready = link_->connect(stops_);
  ready = ready ? wait_for_arm() : Error{"inverse3: " + ready.error().message};
  if (!ready) return link_.reset(), say(ready.error().message), ready;
  spec_ = spec_of(link_->arm(), link_->id());
  wanted_.write({});
  publish();
  thread_ = std::thread([this] { serve(); });
  return Done{};
}

Status Inverse3::wait_for_arm() {
  const double end = steady_seconds() + options_.patience;
  for (int asked = 0;; asked++) {
    if (link_->arm().is_allocated) return Done{};
    if (options_.which.empty() && link_->ids().size() > 1)
      return Error{fmt::format("inverse3: there are the arms {}; say which", listed(link_->ids()))};
    const std::string fault = fault_of(options_, *link_);
    say(fault);
    if (steady_seconds() >= end)
      return Error{fmt::format("{}; asked {} times in {:g} s", fault, asked, options_.patience)};
    pause(std::min(kAskAgain, end - steady_seconds()));
    if (Status heard = link_->talk({}, stops_); !heard) return Error{"inverse3: " + heard.error().message};
  }
}

void Inverse3::serve() {
  for (double next = steady_seconds(); !stops_; next = std::max(next + kPeriod, steady_seconds() - kPeriod)) {
    const Status served = serve_once();
    if (!served) say("inverse3: " + served.error().message);
    publish();
    const bool waits = !served || !link_->arm().is_allocated;
    if (waits && !stops_) pause(kAskAgain);
    pause(next + kPeriod - steady_seconds());
  }
  link_->say_goodbye();
}

/// One command and its answer, or a try to connect.
Status Inverse3::serve_once() {
  if (!link_->is_connected()) return link_->connect(stops_);
  const Wanted& wanted = wanted_.read();
  const bool holds = steady_seconds() - wanted.time < kForgotten;
  return link_->talk(holds ? wanted.force : Vec3d{}, stops_);
}

/// Tells the haptic thread what was heard, and others what is wrong.
void Inverse3::publish() {
  Sample sample;
  if (link_->is_connected()) {
    const Inverse3Arm& arm = link_->arm();
    sample.input = {.pose = {arm.position, axes_of(arm.orientation)},
                    .velocity = arm.velocity,
                    .buttons = arm.buttons,
                    .time = steady_seconds()};
    measure_turning(sample.input);
    const bool can_be = is_plausible(sample.input);
    const std::string fault = fault_of(options_, *link_);
    sample.is_usable = can_be && fault.empty();
    heard_at_ = sample.input.time;
    say(fault.empty() && !can_be ? "inverse3: the arm tells of a place or a speed that cannot be" : fault);
  }
  sample_.write(sample);
}

/// The service does not tell how fast a grip turns.
void Inverse3::measure_turning(DeviceInput& input) {
  const double passed = input.time - turned_at_;
  if (passed >= kTurnWindow) {
    angular_velocity_ = passed < 2 * kTurnWindow
                            ? rotation_vector(input.pose.axes * transposed(turned_from_)) / passed
                            : Vec3d{};
    turned_from_ = input.pose.axes;
    turned_at_ = input.time;
  }
  input.angular_velocity = angular_velocity_;
}

bool Inverse3::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  const double now = steady_seconds();
  wanted_.write({to_be_sent(spec_, output).force, now});
  const Sample& sample = sample_.read();
  if (!sample.is_usable || now - sample.input.time > kLate) return false;
  input = sample.input;
  return true;
}

void Inverse3::close() noexcept {
  stops_ = true;
  if (thread_.joinable()) thread_.join();
  link_.reset();
  sample_.write({});
  try {
    say("inverse3: it is not open");
  } catch (...) {  // no memory for a sentence
  }
}

std::string Inverse3::trouble() const {
  const std::lock_guard lock(mutex_);
  const double silent = steady_seconds() - heard_at_;
  if (!trouble_.empty() || silent <= kLate) return trouble_;
  return fmt::format("inverse3: the Inverse Service at {} has not answered for {:.3f} s", options_.address,
                     silent);
}

/// In pieces, so that close need not wait.
void Inverse3::pause(double seconds) const {
  constexpr double kPiece = 0.05;
  for (const double end = steady_seconds() + seconds; !stops_ && steady_seconds() < end;)
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(kPiece, end - steady_seconds())));
}

void Inverse3::say(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  if (trouble_ != trouble) trouble_ = trouble;
}

void look_for_inverse3(const DeviceOptions& options, DeviceListing& listing) {
  const std::atomic<bool> stops = false;
  Inverse3Link link(options.address, "");
  if (Status connected = link.connect(stops); !connected) {
    listing.note = connected.error().message;
    return;
  }
  listing.connected = link.ids();
  listing.note = fmt::format("the Inverse Service at {} answers{}", options.address,
                             link.ids().empty() ? "; connect an arm and switch it on" : "");
  link.say_goodbye();
}

}  // namespace turgor::haptics
