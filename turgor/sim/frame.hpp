// Input and report of a frame of a world; every model contributes to the report.
#pragma once

#include "turgor/contact/tool.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

struct FrameReport {
  bool finite = true;          // false: the step of a model was undone
  double seconds = 0;          // wall time
  double largest_speed = 0;    // [m/s]
  lattice::Residual residual;  // on request; the largest over all bodies
};

/// Time interval of a frame. Bodies read everything else from the world.
struct FrameInput {
  double from = 0, to = 0;        // [s]
  bool measure_residual = false;  // costs about one sweep
};

/// A tool at the end of the latest frame.
struct ToolNow {
  contact::Pose pose;
  Vec3d force;         // on the tool [N]
  double opening = 0;  // of the jaws [m]
};

}  // namespace turgor
