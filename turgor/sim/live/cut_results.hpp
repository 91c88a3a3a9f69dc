// Progress and result of the latest cut that was made by a request: how far the blade is, and the open wound.
#pragma once

#include <optional>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor {

struct World;

struct CutResult {
  int cut = -1;                                    // number in World::cuts; -1: none
  double done = 0;                                 // finished fraction of the path
  double depth = 0;                                // of the blade below the skin [m]
  bool is_measured = false;                        // true once the blade is at its end
  double length = 0, gape_max = 0, gape_mean = 0;  // of the wound [m]
};

/// Memory between measurements.
struct CutMeasuring {
  lattice::BodySurface near;  // around the cuts of a body without tools
  int cut = -1;               // that was measured last
  double time = 0;            // of the last measurement [s]
};

/// Updates the result of the latest cut after the first `scene_cuts` ones. The wound is measured at most four
/// times per simulated second.
void update_cut_result(const Exec& exec, const World& world, std::size_t scene_cuts, CutMeasuring& measuring,
                       CutResult& result);

}  // namespace turgor
