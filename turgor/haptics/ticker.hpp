// One tick of the haptic loop, on any thread: read the hands, run the model, apply the safety chain, publish.
// Used by loop.cpp.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "turgor/core/latest.hpp"
#include "turgor/haptics/loop.hpp"

namespace turgor::haptics {

/// Mailbox of a device that calls from its own thread: it writes the hand's state and reads the newest
/// output.
struct Mailbox {
  struct TimedOutput {
    SafeOutput output;
    double time = -1e9;  // [s]
  };
  latest<DeviceInput> hand;
  latest<TimedOutput> output;
  std::atomic<double> called_at = 0;  // time of its last call [s]
};

/// Loss of a device as its user has been told of it. Owned by the thread of Loop::news.
struct Loss {
  bool is_lost = false;
  int count = 0;                // number of losses, as that of the haptic thread
  std::string reason, remarks;  // of the device, before it was closed
};

/// Run-time state of a hand.
struct RunningHand {
  Hand hand;
  Safety safety;
  Clutch clutch;
  CoupledTool tool;  // if there is a coupling
  SafeOutput output;
  DeviceInput input;
  bool answered = false;  // in this tick
  double read = 0;        // time of the last reading [s]
  Vec3d model_force;      // of the last tick [N]
  double retry_at = 0;    // earliest time of the next exchange with a lost device [s]
  bool is_pacer = false;  // its device calls and thereby keeps the time
  std::atomic<bool> lost = false;
  std::atomic<int> losses = 0;
  Loss loss;
  latest<HandStatus> status;
  Mailbox mailbox;

  bool calls() const { return hand.device->pacing() == Pacing::kCallback; }
};

struct Ticker {
  std::vector<std::unique_ptr<RunningHand>> hands;
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  ToolTick model_tick = nullptr;
  void* context = nullptr;
  double rate = 1000;            // [Hz]
  bool is_device_paced = false;  // a device's own thread runs the ticks
  std::uint64_t ticks = 0;
  double began = 0, reported = 0;  // [s]
  TimingRecord record;
  latest<TimingReport> report;
  std::atomic<bool> stopping = false, threw = false;
};

/// Time after which the output for a device that calls is not sent [s].
constexpr double kStale = 0.02;

/// Runs a tick of all hands. False when no more ticks are needed, because no force is left and none will
/// come.
bool run_tick(Ticker& ticker);
/// Sends zero force to the devices that do not call.
void send_zero_forces(Ticker& ticker);
/// Publishes the report.
void publish_report(Ticker& ticker, double now);

}  // namespace turgor::haptics
