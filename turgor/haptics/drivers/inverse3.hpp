// Driver for Haply Inverse3, Inverse3x and Minverse through the Inverse Service, a separate process with JSON
// messages over a WebSocket. A thread of the driver communicates with it 2 000 times a second, because an
// answer may be late and parsing JSON allocates. The haptic thread exchanges whole values with that thread
// and never waits.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "turgor/core/latest.hpp"
#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"

namespace turgor::haptics {

class Inverse3Link;

class Inverse3 final : public Device {
 public:
  explicit Inverse3(const DeviceOptions& options);
  ~Inverse3() override;

  /// Waits up to options.patience for an arm, with a request each second. An arm that is not calibrated
  /// opens, and trouble() reports it until it is calibrated. A lost service or arm is requested once a second
  /// until close.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  /// Also false when the last answer is older than 20 ms or the arm is not calibrated. A force is rendered
  /// for at most 50 ms without another exchange, then it is zero.
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override;
  std::string trouble() const override;

 private:
  struct Wanted {
    Vec3d force;      // [N]
    double time = 0;  // of the exchange [s]
  };
  struct Sample {
    DeviceInput input;
    bool is_usable = false;
  };

  // Called by open, then by the driver's thread.
  Status wait_for_arm();
  void serve();
  Status serve_once();
  void publish();
  void measure_rotation(DeviceInput& input);
  void pause(double seconds) const;
  void set_trouble(const std::string& trouble);

  const DeviceOptions options_;
  DeviceSpec spec_;
  std::unique_ptr<Inverse3Link> link_;
  Mat3d last_axes_;         // of the grip at the last measurement of its rotation
  double measured_at_ = 0;  // time of that measurement [s]
  Vec3d angular_velocity_;  // of the grip [rad/s]

  latest<Wanted> wanted_;
  latest<Sample> sample_;
  std::atomic<double> answered_at_ = 0;  // time of the last answer [s]
  std::atomic<bool> stop_requested_ = false;
  mutable std::mutex mutex_;
  std::string trouble_;  // guarded by the mutex
  std::thread thread_;
};

void list_inverse3(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
