// Force Dimension's arms (omega, delta, sigma, lambda) and the Novint Falcon, through the vendor's library.
// exchange talks to the arm over USB and takes about a quarter of a millisecond. The vendor's own guards stay
// as they are: the velocity threshold, the force limit, and a watchdog that lets go after 32 ms of silence.
#pragma once

#include <atomic>
#include <string>

#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"
#include "turgor/haptics/drivers/dhd_library.hpp"

namespace turgor::haptics {

/// What is known of a type of arm (dhdGetSystemType); name, wrist and gripper are the arm's own to tell.
DeviceSpec dhd_spec(int system_type);

class Dhd final : public Device {
 public:
  explicit Dhd(const DeviceOptions& options) : options_(options) {}
  ~Dhd() override { close(); }

  /// Error besides: the arm has not found its zero, and options.may_move is false.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  /// False besides: forces are off (the arm moved too fast, its button, its watchdog). They come back when
  /// the user switches them on; after the watchdog, when less than 0.2 N is wanted.
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override;
  std::string trouble() const override;

 private:
  enum class Condition { kGood, kClosed, kFailed, kUnplugged, kInReset, kForcesOff, kImplausible };

  Status open_arm();
  Status find_zero();
  Status prepare();
  bool send(const DeviceOutput& output) noexcept;
  bool receive(DeviceInput& input) noexcept;
  Condition look(double wanted_force) noexcept;
  bool fail(Condition condition) noexcept;
  Error error(const std::string& what) const;

  const DeviceOptions options_;
  DhdLibrary dhd_{};
  DeviceSpec spec_;
  char id_ = -1;
  bool is_open_ = false, is_drd_ = false;
  int exchanges_ = 0;
  std::atomic<Condition> condition_ = Condition::kClosed;
  std::atomic<int> cause_ = 0;                  // of forces that are off
  std::atomic<const char*> failure_ = nullptr;  // the vendor's sentence, which the library owns
};

void look_for_dhd(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
