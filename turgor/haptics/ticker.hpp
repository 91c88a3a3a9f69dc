// One tick of the haptic loop, whoever's thread it is on: hands are read, the model is asked, the safety
// chain looks, everybody is told. Used by loop.cpp.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "turgor/core/latest.hpp"
#include "turgor/haptics/loop.hpp"

namespace turgor::haptics {

/// Where a device that calls from a thread of its own leaves its hand and takes what lies there.
struct Box {
  struct Given {
    SafeOutput output;
    double time = -1e9;  // [s]
  };
  latest<DeviceInput> hand;
  latest<Given> given;
  std::atomic<double> heard = 0;  // when it called last [s]
};

/// A hand while the loop runs.
struct RunningHand {
  Hand hand;
  Safety safety;
  Clutch clutch;
  CoupledTool tool;  // where there is a coupling
  SafeOutput output;
  DeviceInput input;
  bool answered = false;  // in this tick
  double read = 0;        // when [s]
  Vec3d asked;            // by the model in the last tick [N]
  std::atomic<bool> lost = false;
  latest<HandStatus> status;
  Box box;

  bool calls() const { return hand.device->pacing() == Pacing::kCallback; }
};

struct Ticker {
  std::vector<std::unique_ptr<RunningHand>> hands;
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  ToolTick tick = nullptr;
  void* context = nullptr;
  double rate = 1000;   // [Hz]
  bool called = false;  // a device's own thread runs it
  std::uint64_t ticks = 0;
  double began = 0, reported = 0;  // [s]
  TimingRecord record;
  latest<TimingReport> report;
  std::atomic<bool> stopping = false, threw = false;
};

/// A tick of all hands. False: no more are needed, for nothing is felt and nothing will be.
bool step(Ticker& ticker);
/// The last thing devices hear that do not call.
void let_go(Ticker& ticker);
/// Puts the report where its reader finds it.
void publish_report(Ticker& ticker, double now);

}  // namespace turgor::haptics
