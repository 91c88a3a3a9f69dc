// What a tick asks of a tool and what it answers: the whole of what a hand, a path or a recording says, and
// the whole of what is felt.
#pragma once

#include <algorithm>

#include "turgor/contact/tool.hpp"

namespace turgor::contact {

/// Where a tool is and what its user does with it.
struct ToolCommand {
  Pose pose;
  double grip = 0;    // of forceps: how far they are closed, 0 open, 1 closed
  bool hold = false;  // what is touched when this begins is carried with the tool until it ends
};

/// What is felt.
struct ToolReading {
  Vec3d force, torque;        // on the tool, the torque about its origin [N] [N·m]
  double squeeze = 0;         // of its jaws on what is between them [N]
  double depth = 0;           // of its deepest point below the surface at rest [m]
  int contacts = 0;           // places that bear force
  bool beyond_patch = false;  // it reaches beyond what the model knows there: the force may lack some of it
  double age = 0;  // of the state of the body that this was computed from; 0: of this very tick [s]
};

/// Where the jaws of a tool are `dt` later that closes while its user holds and opens else; the whole way
/// takes `closing_time` [s].
inline double next_grip(double grip, bool hold, double closing_time, double dt) {
  const double step = dt / closing_time;
  return std::clamp(hold ? grip + step : grip - step, 0.0, 1.0);
}

}  // namespace turgor::contact
