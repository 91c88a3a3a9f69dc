// Driver for Force Dimension's arms (omega, delta, sigma, lambda) and the Novint Falcon, with the vendor's
// library. exchange communicates over USB and takes about a quarter of a millisecond. The vendor's own
// protections remain active: the velocity threshold, the force limit, and a watchdog that switches forces off
// after 32 ms without a command.
#pragma once

#include <atomic>
#include <string>

#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"
#include "turgor/haptics/drivers/dhd_library.hpp"

namespace turgor::haptics {

/// Specification of an arm's type (dhdGetSystemType), without name, wrist and gripper, which are read from
/// the arm.
DeviceSpec dhd_spec(int system_type);

class Dhd final : public Device {
 public:
  explicit Dhd(const DeviceOptions& options) : options_(options) {}
  ~Dhd() override { close(); }

  /// Additional error: the arm has not found its zero, and options.may_move is false.
  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  /// Also false while forces are off (velocity limit, button or watchdog of the arm). They return when the
  /// user switches them on. After the watchdog they return when less than 0.2 N is requested.
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
  Condition check_state(double wanted_force) noexcept;
  bool fail(Condition condition) noexcept;
  Error error(const std::string& what) const;

  const DeviceOptions options_;
  DhdLibrary dhd_{};
  DeviceSpec spec_;
  char id_ = -1;
  bool is_open_ = false, is_drd_ = false;
  int exchanges_ = 0;
  std::atomic<Condition> condition_ = Condition::kClosed;
  std::atomic<int> cause_ = 0;                  // reason for which forces are off
  std::atomic<const char*> failure_ = nullptr;  // error text, owned by the vendor's library
};

void list_dhd(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
