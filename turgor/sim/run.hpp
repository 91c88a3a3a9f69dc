// Simulation of a whole scene, frame by frame, with snapshots and measurements. Observers are called after
// every frame and at every snapshot. They cannot change the world, so that the result does not depend on
// them.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

struct Simulated;

/// Callbacks; each may be empty.
struct RunEvents {
  Progress progress;
  std::function<bool(const World&)> frame;  // after every frame; false ends the run
  std::function<Status(const World&, const WorldSnapshot&)>
      snapshot;                                         // first, last, and at the scene's interval
  std::function<Status(const WorldSnapshot&)> picture;  // after frames for which wants_picture is true
  std::function<bool(const World&)> wants_picture;
  std::function<Status(const World&, const Simulated&)> end_of_frame;  // after everything else of a frame
};

/// Result of a run, besides the world.
struct Simulated {
  Measures measures;
  WorldSnapshot snapshot;   // of the latest snapshot or the last frame
  double show_seconds = 0;  // wall time of filling snapshots
  std::string stopped;      // reason of an early end: a sentence; else empty
  bool finite = true;       // false: the next step was not finite, the state before it was kept
};

/// Simulates a loaded world to the end of the scene. A world that was restored after some frames comes with
/// the result so far. `shown`: a snapshot of the world or empty; its surfaces are used again. Error: of a
/// step, or of a callback.
Result<Simulated> simulate(const Exec& exec, const Scene& scene, World& world, const RunEvents& events = {},
                           std::optional<Simulated> resumed = {}, WorldSnapshot shown = {});

}  // namespace turgor
