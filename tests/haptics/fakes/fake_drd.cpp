// Replacement of Force Dimension's libdrd: its documented functions around an arm that a test moves.
#include "haptics/fakes/fake_drd.hpp"

#include <algorithm>
#include <cmath>

namespace {

FakeDrd arm;

int answer() { return arm.is_unplugged ? -1 : 0; }
int give(const double (&from)[3], double* x, double* y, double* z) {
  *x = from[0], *y = from[1], *z = from[2];
  return answer();
}
double sent_force() { return std::hypot(arm.force[0], arm.force[1], arm.force[2]); }
int open_arm(int id) {
  if (arm.device_count <= id) return -1;
  arm.is_open = true;
  arm.opened_id = id;
  return id;
}

}  // namespace

extern "C" {

FakeDrd* fake_drd() { return &arm; }

int dhdGetDeviceCount() { return arm.device_count; }
int dhdOpen() { return open_arm(0); }
int dhdOpenID(char id) { return open_arm(id); }
int dhdClose(char) { return arm.is_open = false, answer(); }
int dhdGetSystemType(char) { return arm.type; }
const char* dhdGetSystemName(char) { return "fake arm"; }
bool dhdHasWrist(char) { return arm.has_wrist; }
bool dhdHasActiveWrist(char) { return arm.has_active_wrist; }
bool dhdHasGripper(char) { return arm.has_gripper; }
bool dhdHasActiveGripper(char) { return arm.has_gripper; }
int dhdEnableForce(unsigned char on, char) {
  if (!on) arm.force_when_switched_off = sent_force();
  arm.are_forces_on = on;
  if (on) arm.forces_off_cause = 0;
  return answer();
}
int dhdSetGravityCompensation(int on, char) { return arm.has_gravity_compensation = on, answer(); }
int dhdSetMaxForce(double newtons, char) { return arm.max_force = newtons, answer(); }
int dhdEnableExpertMode() { return answer(); }
int dhdDisableExpertMode() { return answer(); }
int dhdSetWatchdog(unsigned char n, char) { return arm.watchdog = n, answer(); }
int dhdSetVelocityThreshold(unsigned, char) { return arm.velocity_thresholds++, answer(); }
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz,
                                        double fg, char) {
  const double force[3] = {fx, fy, fz}, torque[3] = {tx, ty, tz};
  std::copy_n(force, 3, arm.force);
  std::copy_n(torque, 3, arm.torque);
  arm.gripper_force = fg;
  arm.largest_force = std::max(arm.largest_force, sent_force());
  arm.forces_sent++;
  return answer();
}
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double m[3][3], char) {
  const int moved = arm.readings++ - arm.readings_at_rest;
  for (int i = 0; i < 3 && moved >= 0 && moved < arm.readings_of_approach; i++)
    arm.position[i] += arm.approach[i];
  for (int i = 0; i < 3; i++) std::copy_n(arm.frame[i], 3, m[i]);
  return give(arm.position, x, y, z);
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char) { return give(arm.velocity, x, y, z); }
int dhdGetAngularVelocityRad(double* x, double* y, double* z, char) {
  return give(arm.angular_velocity, x, y, z);
}
int dhdGetGripperAngleRad(double* angle, char) { return *angle = arm.gripper_angle, answer(); }
unsigned dhdGetButtonMask(char) { return arm.buttons; }
int dhdGetStatus(int status[17], char) {
  std::fill_n(status, 17, 0);
  status[1] = arm.connected;
  status[3] = arm.reset;
  status[5] = arm.are_forces_on && arm.forces_off_cause == 0;
  status[14] = arm.forces_off_cause;
  return answer();
}
int dhdErrorGetLast() { return 2; }
const char* dhdErrorGetLastStr() { return "communication error"; }

int drdOpen() { return open_arm(0); }
int drdOpenID(char id) { return open_arm(id); }
int drdClose(char) { return arm.is_open = false, answer(); }
bool drdIsSupported(char) { return arm.is_supported; }
bool drdIsInitialized(char) { return arm.is_initialized; }
int drdAutoInit(char) {
  arm.auto_inits++;
  arm.is_initialized = true;
  return answer();
}
int drdStop(bool, char) { return answer(); }
}
