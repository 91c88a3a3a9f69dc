// How a run goes: frame by frame, with snapshots on the way, and what it measures. Those who look on are told
// after every frame and at every snapshot; nothing of theirs goes back into the world, so that a run gives
// the same bits whoever looks, and however often.
#pragma once

#include <functional>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Any of them may be empty.
struct RunEvents {
  Progress progress;
  std::function<bool(const World&)> frame;  // after every frame; false ends the run
  std::function<Status(const World&, const WorldSnapshot&)> snapshot;  // first, last, and as the scene says
  std::function<Status(const WorldSnapshot&)> picture;                 // after frames of which this is true:
  std::function<bool(const World&)> wants_picture;
};

/// What a run leaves behind besides the world.
struct Simulated {
  Measures measures;
  WorldSnapshot snapshot;   // as at the latest snapshot, the last frame
  double show_seconds = 0;  // wall time of showing the world
  std::string stopped;      // why it ended early: a sentence; empty when it did not
  bool finite = true;       // false: the numbers of the next step were not finite, the state before was kept
};

/// From the world as it was loaded to the end of the scene. Error: a step's, or an event's.
Result<Simulated> simulate(const Exec& exec, const Scene& scene, World& world, const RunEvents& events = {});

}  // namespace turgor
