// What one frame of a world says about itself; every model adds to it.
#pragma once

#include "turgor/contact/tool.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

struct FrameReport {
  bool finite = true;          // false: a model's step was undone
  double seconds = 0;          // wall time
  double largest_speed = 0;    // [m/s]
  lattice::Residual residual;  // when asked for; the largest over all bodies
};

/// What moves a body in a frame, and when. The world is what is around the body, and the body in it.
struct FrameInput {
  double from = 0, to = 0;        // [s]
  bool measure_residual = false;  // costs about one sweep
};

/// A tool at the end of the latest frame.
struct ToolNow {
  contact::Pose pose;
  Vec3d force;         // on it [N]
  double opening = 0;  // of its jaws [m]
};

}  // namespace turgor
