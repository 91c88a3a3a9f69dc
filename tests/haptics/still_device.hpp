// A device at a position that a test sets, with any pacing.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// Stays at its position and stores the forces that it receives.
struct StillDevice : Device {
  explicit StillDevice(Pacing pacing = Pacing::kLoop) : pacing_(pacing) {}
  Status open() override { return Done{}; }
  const DeviceSpec& spec() const override { return spec_; }
  Pacing pacing() const override { return pacing_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override {
    const double force = norm(output.force);
    largest = std::max(largest.load(), force);
    last = force;
    exchanges++;
    std::this_thread::sleep_for(std::chrono::milliseconds(stall_ms.exchange(0)));
    if (pacing_ == Pacing::kDevice) std::this_thread::sleep_for(std::chrono::microseconds(period_us));
    if (unplugged) return false;
    input = {};
    input.pose.position.z = z;
    input.buttons = buttons;
    return true;
  }
  Status start(DeviceTick tick, void* context) override {
    ticking_ = true;
    thread_ = std::thread([this, tick, context] {
      while (ticking_) {
        DeviceInput input;
        input.pose.position.z = z;
        DeviceOutput output;
        tick(context, input, output);
        last = norm(output.force);
        exchanges++;
        std::this_thread::sleep_for(std::chrono::microseconds(period_us));
      }
    });
    return Done{};
  }
  void close() noexcept override {
    ticking_ = false;
    if (thread_.joinable()) thread_.join();
    closed = true;
  }
  std::string trouble() const override { return unplugged ? "its cable is out" : ""; }
  ~StillDevice() override { close(); }

  std::atomic<double> z = 0, largest = 0, last = 0;
  std::atomic<std::uint32_t> buttons = 0;
  std::atomic<int> exchanges = 0, period_us = 1000, stall_ms = 0;  // stall_ms: of one exchange
  std::atomic<bool> unplugged = false, closed = false;

 private:
  DeviceSpec spec_{.name = "still", .force = 12, .torque = 0.4, .mass = 0.2, .rate = 1000};
  Pacing pacing_;
  std::atomic<bool> ticking_ = false;
  std::thread thread_;
};

}  // namespace turgor::haptics
