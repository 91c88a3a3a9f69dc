// Haply Inverse3, Inverse3x and Minverse, through the Inverse Service that runs beside us and speaks JSON
// over a WebSocket. A thread of its own talks to it, 2 000 times a second, because an answer may take its
// time and reading JSON allocates; the haptic thread exchanges whole values with that thread and never waits.
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

  /// Waits for an arm as long as options.patience says, asking once a second. An arm that is not calibrated
  /// is open, and trouble() says so until it is. A service or an arm that goes away is asked for once a
  /// second until close.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  /// False besides: the last answer is older than 20 ms, or the arm is not calibrated. A force is held for
  /// 50 ms at most without another exchange; nothing is felt then.
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

  // Of open, and then of the thread that talks.
  Status wait_for_arm();
  void serve();
  Status serve_once();
  void publish();
  void measure_turning(DeviceInput& input);
  void pause(double seconds) const;
  void say(const std::string& trouble);

  const DeviceOptions options_;
  DeviceSpec spec_;
  std::unique_ptr<Inverse3Link> link_;
  Mat3d turned_from_;       // the grip's axes when its turning was last measured,
  double turned_at_ = 0;    // and when that was [s]
  Vec3d angular_velocity_;  // of the grip [rad/s]

  latest<Wanted> wanted_;
  latest<Sample> sample_;
  std::atomic<double> heard_at_ = 0;  // the last answer [s]
  std::atomic<bool> stops_ = false;
  mutable std::mutex mutex_;
  std::string trouble_;  // guarded by the mutex
  std::thread thread_;
};

void look_for_inverse3(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
