// Stitches that were made by requests: their goal, and the present force and gape.
#pragma once

#include <vector>

#include "turgor/models/lattice/suture/closure.hpp"
#include "turgor/sim/live/requests.hpp"

namespace turgor {

struct HandStitch {
  int suture = 0;         // index into World::sutures
  StitchRequest request;  // with its wound, and the present goal of the pull
  lattice::StitchPhase phase = lattice::StitchPhase::kWaiting;
  double tension = 0;  // of the thread [N]
  double force = 0;    // largest force on a point of the tissue [N]
  double gape = 0;     // opening of the wound under the stitch [m]
};

/// Stitches that follow those of the scene in World::sutures.
std::vector<HandStitch> hand_stitches(const Scene& scene, const World& world);

}  // namespace turgor
