// State of the fake of Force Dimension's library, set and read by tests.
#pragma once

struct FakeDrd {
  // State of the arm in its own frame: x towards the user, y right, z up [m] [m/s] [rad/s].
  int device_count = 1, type = 33;
  bool has_wrist = false, has_active_wrist = false, has_gripper = false;
  bool is_initialized = true, is_supported = true;
  double position[3] = {0, 0, 0};
  double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double velocity[3] = {0, 0, 0}, angular_velocity[3] = {0, 0, 0};
  double gripper_angle = 0;
  unsigned buttons = 0;
  bool is_unplugged = false;       // every call fails
  double approach[3] = {0, 0, 0};  // motion per reading [m], for this many readings after the first ones
  int readings_at_rest = 0, readings_of_approach = 0;
  int connected = 1, reset = 0, forces_off_cause = 0;

  // Calls of the driver.
  double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0}, gripper_force = 0;  // last sent
  double largest_force = 0;                                               // maximum of all sent [N]
  bool is_open = false, are_forces_on = false, has_gravity_compensation = false;
  int readings = 0;
  int opened_id = -1, auto_inits = 0, watchdog = 0, velocity_thresholds = 0, forces_sent = 0;
  double max_force = -1;
  double force_when_switched_off = -1;  // [N]
};

/// Exported by the library as "fake_drd".
using FakeDrdFunction = FakeDrd* (*)();
