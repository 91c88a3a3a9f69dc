// The haptic loop: a thread of its own that reads hands, asks the model what they feel, lets the safety chain
// look at it and hands it to the devices; a thousand times a second or as often as asked. Deadlines are
// absolute, so that one late tick does not delay the next. A tick allocates nothing, takes no lock and writes
// no log; what is to be told is counted (timing_report.hpp) or handed over whole (latest.hpp).
//
// Several devices make one tick: two hands feel the same body at the same moment. Who keeps the time:
//   all devices answer at once (Pacing::kLoop)   the loop's own clock
//   one waits for its own tick (kDevice)         that device, on the loop's thread
//   one calls from a thread of its own (kCallback)  that thread runs the ticks; the loop has no thread.
//                                                With several of them the first one does, the others leave
//                                                their hands in a box and take what lies there.
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

/// The model's part of a tick: one reading a command, in the world. Must not allocate, lock or wait. `dt` is
/// the time since the last tick [s].
using ToolTick = void (*)(void* context, std::span<const contact::ToolCommand> commands, double dt,
                          std::span<contact::ToolReading> readings);

/// A device and what it is for. The device is open, and outlives the loop.
struct Hand {
  Device* device = nullptr;
  Workspace workspace;
  Buttons buttons;
  std::optional<Coupling>
      coupling;  // for bodies stiffer than the device bears; none: the model meets the hand
  SafetyParams safety;
};

struct LoopParams {
  double rate = 1000;       // of a loop that keeps its own time [Hz]
  int priority = 80;        // of SCHED_FIFO, where the system allows it; 0 = as everybody else
  bool lock_memory = true;  // what is in memory stays there, where the system allows it
};

/// One hand at the end of a tick.
struct HandStatus {
  std::uint64_t tick = 0;
  DeviceInput input;             // in the device's frame
  contact::ToolCommand command;  // in the world
  contact::ToolReading reading;  // in the world
  DeviceOutput output;           // what it was given, in the device's frame
  double energy = 0;             // W [J]
  SoftStart start = SoftStart::kWaiting;
  bool lost = false;
};

class Loop {
 public:
  /// Begins to tick. Error: no device, or one that cannot begin; a rate that is none.
  static Result<std::unique_ptr<Loop>> start(const std::vector<Hand>& hands, ToolTick tick, void* context,
                                             const LoopParams& params = {});
  ~Loop();  // stops
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Forces fade within a few ticks, then the thread ends and the devices are closed. More than once is once.
  void stop() noexcept;
  /// False when it was stopped, when every device is lost, or when the model threw.
  bool running() const;

  /// The newest of a hand, by one reader's thread.
  const HandStatus& status(std::size_t hand);
  /// Renewed four times a second, and when it stops; by one reader's thread.
  const TimingReport& report();
  /// What the system did not allow, and which devices were lost and why; a sentence each. Not from a tick.
  std::vector<std::string> notes() const;

 private:
  struct Thread;
  Loop();
  std::unique_ptr<Thread> thread_;
};

}  // namespace turgor::haptics
