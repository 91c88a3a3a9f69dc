// Driver for 3D Systems' Touch, Touch X and Phantom, with the vendor's library (HDAPI). Its scheduler owns
// the haptic thread, with 1 000 ticks a second, so this device calls back: see Device::start.
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

  /// options.which is a name of the vendor's setup, such as "Left Device"; empty = its default. Waits up to
  /// options.patience for an arm whose stylus must be in the inkwell.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  Pacing pacing() const override { return Pacing::kCallback; }
  /// Always false, because the device's own thread calls.
  bool exchange(const DeviceOutput&, DeviceInput&) noexcept override { return false; }
  /// Ticks end with zero force when the device reports an error that is not a warning.
  Status start(DeviceTick tick, void* context) override;
  void close() noexcept override;
  std::string trouble() const override;
  std::string remarks() const override;

 private:
  enum class Stage { kClosed, kReady, kRunning, kEnding, kLost };

  Status calibrate();
  Status describe();
  static unsigned call(void* self);
  unsigned run_tick() noexcept;
  bool read(DeviceInput& input) const noexcept;
  void set_force(Vec3d force) const noexcept;
  bool read_errors() noexcept;
  void clear_errors() const;

  const DeviceOptions options_;
  HdLibrary hd_{};
  DeviceSpec spec_;
  unsigned handle_ = hd::kNoHandle;
  unsigned long callback_ = 0;
  bool is_scheduled_ = false;
  DeviceTick tick_ = nullptr;
  void* context_ = nullptr;
  std::atomic<Stage> stage_ = Stage::kClosed;
  std::atomic<bool> has_ended_ = false;  // the last tick, with zero force, has run
  std::atomic<unsigned> error_ = 0;
  std::array<std::atomic<int>, 4> warnings_{};  // counts, from kWarmMotors on
  std::atomic<int> implausible_ = 0;            // skipped ticks
};

void list_openhaptics(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
