// Results of a needle for logs and reports.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor::contact {

/// Energy since the start. The parts sum to the hand's work.
struct NeedleWork {
  double hand = 0, cutting = 0, friction = 0;  // [J]
  double spreading = 0, elastic = 0;           // stored now [J]
  // on the motion of the body by other tools, cloth and loads; on lattices contained in `elastic` [J]
  double others = 0;
};

/// Parts of the force along the needle, positive against a push, and its depth.
struct NeedleReading {
  int material = 0;                                 // at the tip, index into the body's materials
  double inserted = 0;                              // length of the shaft in the tissue [m]
  double cutting = 0, spreading = 0, friction = 0;  // [N]
  Vec3d deflection;                                 // of the tip of a needle that bends [m]
};

}  // namespace turgor::contact
