// A device driven by a mouse, or by any other source of target poses. A computed arm (virtual_device.hpp) is
// pulled to the target by a soft spring. Contact forces hold the tool back, as they would hold a hand, but
// the mouse itself renders no force. Its frame is the world frame.
#pragma once

#include <atomic>

#include "turgor/core/latest.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/haptics/virtual_device.hpp"
#include "turgor/haptics/workspace.hpp"

namespace turgor::haptics {

/// Input from a mouse.
struct MouseHand {
  contact::Pose pose;  // target pose of the tool
  bool hold = false;   // carry the touched tissue
  int teleports = 0;   // count of teleports; a new value moves the tool at once
  Vec3d teleport_to;   // to this position, whatever lies between [m]
};

class MouseDevice final : public Device {
 public:
  static constexpr double kStiffness = 600;  // of the spring [N/m]

  /// `reach`: range of the tool [m].
  explicit MouseDevice(const Box& reach);

  /// Sets the target; called by one thread other than the loop's. The tool follows the mouse from the first
  /// exchange after the first call.
  void set_target(const MouseHand& hand);
  /// True when the newest exchange used a target of the mouse.
  const std::atomic<bool>& is_driven() const { return is_driven_; }

  Status open() override { return arm_.open(); }
  const DeviceSpec& spec() const override { return spec_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override { arm_.close(); }

 private:
  latest<MouseHand> target_;
  std::atomic<bool> is_driven_ = false;
  int teleports_ = 0;
  HandTarget goal_;  // of the spring; follows the jumps of the mouse smoothly
  VirtualDevice arm_;
  DeviceSpec spec_;
};

}  // namespace turgor::haptics
