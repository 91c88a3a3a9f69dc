// State of the fake of 3D Systems' HDAPI, set and read by tests. All members are atomic, because the
// scheduler is a thread.
#pragma once

#include <array>
#include <atomic>

struct FakeHd {
  // State of the arm in its own frame and units: x right, y up, z towards the user [mm] [mm/s] [rad/s].
  std::array<std::atomic<double>, 16> transform{};  // column-major, as in OpenGL
  std::array<std::atomic<double>, 3> velocity{}, angular_velocity{};
  std::atomic<int> buttons = 0;
  std::atomic<unsigned> calibration = 0x5000;
  std::atomic<int> calibration_styles = 4;  // inkwell
  std::atomic<unsigned> init_error = 0, next_error = 0;
  std::atomic<double> max_force = 3.3;  // [N]

  // Calls of the driver.
  std::array<std::atomic<double>, 3> force{};  // last sent [N]
  std::atomic<double> largest_force = 0;       // maximum of all sent [N]
  std::atomic<double> force_when_disabled = -1;
  std::atomic<int> forces_outside_frames = 0, ticks = 0, updates = 0;
  std::atomic<bool> is_open = false, is_running = false, is_force_on = false;

  void reset() {
    for (std::size_t i = 0; i < 16; i++) transform[i] = i % 5 == 0 ? 1 : 0;
    for (std::size_t i = 0; i < 3; i++) velocity[i] = angular_velocity[i] = force[i] = 0;
    buttons = 0, calibration = 0x5000, calibration_styles = 4, init_error = 0, next_error = 0,
    max_force = 3.3;
    largest_force = 0, force_when_disabled = -1, forces_outside_frames = 0, ticks = 0, updates = 0;
    is_open = is_running = is_force_on = false;
  }
};

/// Exported by the library as "fake_hd".
using FakeHdFunction = FakeHd* (*)();
