// Replacement of 3D Systems' libHD: its documented functions, a scheduler of 1 kHz and an arm that a test
// moves.
#include "haptics/fakes/fake_hd.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace {

FakeHd arm;
constexpr unsigned kHandle = 7;
std::atomic<bool> in_frame = false, stops = false;
unsigned (*callback)(void*) = nullptr;
void* context = nullptr;
std::thread scheduler;

double sent_force() { return std::hypot(arm.force[0].load(), arm.force[1].load(), arm.force[2].load()); }

template <std::size_t N>
void copy(const std::array<std::atomic<double>, N>& from, double* to) {
  std::copy(from.begin(), from.end(), to);
}

void tick_until_stopped() {
  while (!stops) {
    arm.ticks++;
    if (callback && callback(context) == 0) callback = nullptr;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

extern "C" {

struct HDErrorInfo {
  unsigned code;
  int internal;
  unsigned handle;
};

FakeHd* fake_hd() { return &arm; }

unsigned hdInitDevice(const char*) {
  arm.next_error = arm.init_error.load();
  if (arm.init_error) return 0xffffffff;
  arm.is_open = true;
  return kHandle;
}
void hdDisableDevice(unsigned) {
  arm.force_when_disabled = sent_force();
  arm.is_open = false;
}
void hdMakeCurrentDevice(unsigned) {}
void hdBeginFrame(unsigned) { in_frame = true; }
void hdEndFrame(unsigned) { in_frame = false; }
HDErrorInfo hdGetError() { return {arm.next_error.exchange(0), 0, kHandle}; }
void hdEnable(unsigned capability) {
  if (capability == 0x4000) arm.is_force_on = true;
}
void hdDisable(unsigned capability) {
  if (capability == 0x4000) arm.is_force_on = false;
}
void hdGetIntegerv(unsigned parameter, int* value) {
  if (parameter == 0x2000) *value = arm.buttons;
  if (parameter == 0x2555) *value = arm.calibration_styles;
}
void hdGetDoublev(unsigned parameter, double* values) {
  if (parameter == 0x2051) copy(arm.velocity, values);
  if (parameter == 0x2052) copy(arm.transform, values);
  if (parameter == 0x2053) copy(arm.angular_velocity, values);
  if (parameter == 0x2602) *values = 0.4;  // N/mm
  if (parameter == 0x2603) *values = arm.max_force;
  if (parameter == 0x2609) *values = 0.005;  // N·s/mm
  const double box[6] = {-80, -60, -35, 80, 60, 35};
  if (parameter == 0x2551) std::copy_n(box, 6, values);
}
void hdSetDoublev(unsigned parameter, const double* values) {
  if (parameter != 0x2700) return;
  if (!in_frame) arm.forces_outside_frames++;
  std::copy_n(values, 3, arm.force.begin());
  arm.largest_force = std::max(arm.largest_force.load(), sent_force());
}
const char* hdGetString(unsigned parameter) { return parameter == 0x2501 ? "Touch" : "00042"; }
unsigned hdCheckCalibration() { return arm.calibration; }
void hdUpdateCalibration(unsigned) {
  arm.updates++;
  arm.calibration = 0x5000;
}
void hdStartScheduler() {
  stops = false;
  arm.is_running = true;
  scheduler = std::thread(tick_until_stopped);
}
void hdStopScheduler() {
  stops = true;
  if (scheduler.joinable()) scheduler.join();
  arm.is_running = false;
}
unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* its, unsigned short) {
  callback = function;
  context = its;
  return 1;
}
void hdUnschedule(unsigned long) { callback = nullptr; }
}
