// The haptic loop: a thread that reads the hands, runs the model's tick, applies the safety chain and sends
// the forces to the devices, by default at 1 kHz. Deadlines are absolute, so that one late tick does not
// delay the next. A tick allocates nothing, takes no lock and writes no log. Diagnostics are counted
// (timing_report.hpp) or published whole (latest.hpp).
//
// Several devices share one tick: two hands feel the same body at the same time. Timing source:
//   all devices return at once (Pacing::kLoop)   the loop's own clock
//   one waits for its own tick (kDevice)         that device, on the loop's thread
//   one calls from its own thread (kCallback)    that thread runs the ticks. Of several such devices the
//                                                first one runs them. The others exchange hand and force
//                                                through a mailbox. While the first one does not call, the
//                                                loop's own clock runs the ticks.
//
// A lost device gets zero force, and the ticks go on. When it answers again, its force starts softly.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turgor/contact/tool_io.hpp"
#include "turgor/haptics/coupling.hpp"
#include "turgor/haptics/device.hpp"
#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/timing_report.hpp"
#include "turgor/haptics/workspace.hpp"

namespace turgor::haptics {

/// The model's tick: one reading a command, in the world frame. Must not allocate, lock or wait. `dt` is the
/// time since the last tick [s].
using ToolTick = void (*)(void* context, std::span<const contact::ToolCommand> commands, double dt,
                          std::span<contact::ToolReading> readings);

/// A device and its use. The device is open and outlives the loop.
struct Hand {
  Device* device = nullptr;
  Workspace workspace;
  Buttons buttons;
  std::optional<Coupling>
      coupling;  // for bodies stiffer than the device can render; none: the hand touches the model directly
  SafetyParams safety;
};

struct LoopParams {
  double rate = 1000;       // of a loop with its own clock: see loop_rate [Hz]
  int priority = 80;        // of SCHED_FIFO, where the system allows it; 0 = normal scheduling
  bool lock_memory = true;  // locks memory pages, where the system allows it
};

/// Rate of the loop with these devices [Hz]: that of the first device that calls, else of the slowest device
/// that keeps its own time, else `requested`.
double loop_rate(std::span<const Hand> hands, double requested);

/// State of one hand at the end of a tick.
struct HandStatus {
  std::uint64_t tick = 0;
  DeviceInput input;             // in the device's frame
  contact::ToolCommand command;  // in the world
  contact::ToolReading reading;  // in the world
  DeviceOutput output;           // sent to the device, in the device's frame
  double energy = 0;             // W [J]
  SoftStart start = SoftStart::kWaiting;
  bool lost = false;
};

class Loop {
 public:
  /// Starts ticking. Error: no device, a device or a thread that cannot start, or an
  /// invalid rate.
  static Result<std::unique_ptr<Loop>> start(const std::vector<Hand>& hands, ToolTick tick, void* context,
                                             const LoopParams& params = {});
  ~Loop();  // stops
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Fades forces within a few ticks, ends the thread and closes the devices. Repeated calls have no effect.
  void stop() noexcept;
  /// False when the loop was stopped, or when the model threw an exception. A loop whose devices are lost
  /// runs.
  bool running() const;

  /// Newest status of a hand, for one reader thread.
  const HandStatus& status(std::size_t hand);
  /// Updated four times a second and at the end; for one reader thread.
  const TimingReport& report();
  /// Devices that were lost or that returned since the last call, and a failure of the model, a sentence
  /// each. For one thread, not the haptic one. The reason of a loss is known only to a call before the
  /// return.
  std::vector<std::string> news();
  /// Notes on refused system settings and on lost devices with the reason, a sentence each. For the thread of
  /// news().
  std::vector<std::string> notes();

 private:
  struct Thread;
  Loop();
  std::unique_ptr<Thread> thread_;
};

}  // namespace turgor::haptics
