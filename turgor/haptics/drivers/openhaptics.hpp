// 3D Systems' Touch, Touch X and Phantom, through the vendor's library (HDAPI). Its scheduler owns the haptic
// thread, 1 000 ticks a second, so this device calls: see Device::start.
#pragma once

#include <array>
#include <atomic>
#include <string>

#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"
#include "turgor/haptics/drivers/hd_library.hpp"

namespace turgor::haptics {

class OpenHaptics final : public Device {
 public:
  explicit OpenHaptics(const DeviceOptions& options) : options_(options) {}
  ~OpenHaptics() override { close(); }

  /// options.which is a name of the vendor's setup, as "Left Device"; empty = its default. An arm that wants
  /// its stylus in the inkwell is waited for as long as options.patience says.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  Pacing pacing() const override { return Pacing::kCallback; }
  /// False: the device's own thread calls.
  bool exchange(const DeviceOutput&, DeviceInput&) noexcept override { return false; }
  /// Ticks end, with no force, when the device reports an error that is no warning.
  Status start(DeviceTick tick, void* context) override;
  void close() noexcept override;
  std::string trouble() const override;
  std::string remarks() const override;

 private:
  enum class Stage { kClosed, kReady, kRunning, kEnding, kLost };

  Status calibrate();
  Status describe();
  static unsigned call(void* self);
  unsigned feel() noexcept;
  bool read(DeviceInput& input) const noexcept;
  void set_force(Vec3d force) const noexcept;
  bool take_errors() noexcept;
  void forget_errors() const;

  const DeviceOptions options_;
  HdLibrary hd_{};
  DeviceSpec spec_;
  unsigned handle_ = hd::kNoHandle;
  unsigned long callback_ = 0;
  bool is_scheduled_ = false;
  DeviceTick tick_ = nullptr;
  void* context_ = nullptr;
  std::atomic<Stage> stage_ = Stage::kClosed;
  std::atomic<bool> has_ended_ = false;  // the last tick felt nothing
  std::atomic<unsigned> error_ = 0;
  std::array<std::atomic<int>, 4> warnings_{};  // from kWarmMotors on
  std::atomic<int> implausible_ = 0;            // ticks left out
};

void look_for_openhaptics(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
