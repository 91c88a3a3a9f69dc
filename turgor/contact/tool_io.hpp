// Input and output of a tool in a tick. The command comes from a hand, a path or a recording. The reading
// contains the force for the hand.
#pragma once

#include <algorithm>

#include "turgor/contact/tool.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

/// Pose of a tool and actions of its user.
struct ToolCommand {
  Pose pose;
  double grip = 0;    // closure of the jaws: 0 open, 1 closed
  bool hold = false;  // true: the tool carries the tissue that it touched when `hold` became true
};

/// Haptic result of a tick.
struct ToolReading {
  Vec3d force, torque;        // on the tool; torque about its origin [N] [N·m]
  double squeeze = 0;         // force of the jaws on the tissue between them [N]
  double depth = 0;           // depth of the tool's deepest point below the surface at rest [m]
  int contacts = 0;           // number of contact points that bear force
  bool beyond_patch = false;  // contact beyond the model's patch: a fraction of the force may be missing
  double age = 0;             // age of the body state that the force is based on; 0: this tick [s]
};

/// Grip after `dt` seconds: rises while `hold` is true and falls otherwise. A full stroke takes
/// `closing_time` [s].
inline double next_grip(double grip, bool hold, double closing_time, double dt) {
  TURGOR_CHECK(closing_time > 0 && dt >= 0, "a grip closes in a positive time");
  const double step = dt / closing_time;
  return std::clamp(hold ? grip + step : grip - step, 0.0, 1.0);
}

}  // namespace turgor::contact
