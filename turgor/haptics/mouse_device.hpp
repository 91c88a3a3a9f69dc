// A device whose hand is a mouse, or whatever else says where a tool shall be: an arm that is computed
// (virtual_device.hpp), led to that place by a soft spring. What presses back makes the tool stay behind, as
// a hand would be held up; the mouse itself feels nothing. Its frame is the world's.
#pragma once

#include <atomic>

#include "turgor/core/latest.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/haptics/virtual_device.hpp"
#include "turgor/haptics/workspace.hpp"

namespace turgor::haptics {

/// What a mouse says.
struct MouseHand {
  contact::Pose pose;  // where the tool shall be
  bool hold = false;   // and carry what it touches
  int put = 0;         // another number than before: its way begins at once from
  Vec3d put_at;        // there, whatever lies between [m]
};

class MouseDevice final : public Device {
 public:
  static constexpr double kStiffness = 600;  // of the spring [N/m]

  /// `reach`: where the tool can go [m].
  explicit MouseDevice(const Box& reach);

  /// By one thread, which is not the loop's. From the exchange after the first time on the tool is the
  /// mouse's.
  void lead(const MouseHand& hand);
  /// Did the newest exchange say where the mouse is?
  const std::atomic<bool>& is_led() const { return is_led_; }

  Status open() override { return arm_.open(); }
  const DeviceSpec& spec() const override { return spec_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override { arm_.close(); }

 private:
  latest<MouseHand> said_;
  std::atomic<bool> is_led_ = false;
  int put_ = 0;
  HandTarget goal_;  // of the spring: follows the mouse, whose places come by jumps
  VirtualDevice arm_;
  DeviceSpec spec_;
};

}  // namespace turgor::haptics
