// Sutures in measures and reports.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A suture at the end of a frame.
struct SutureSample {
  double time = 0;           // [s]
  double closing_force = 0;  // of all stitches on a lip, less the pressure of the walls [N]
  double tension_max = 0;    // [N]
  double gape_max = 0;       // under a stitch that bears [m]
  double thread_length = 0;  // without stress, in all stitches that bear [m]
  int bearing = 0, pulled_out = 0, broken = 0;  // stitches
};
struct StitchSample {
  double along = 0;    // on the wound [m]
  double tension = 0;  // of the thread [N]
  double stretch = 0;  // of the thread beyond its stress-free length [m]
  double force = 0;    // largest force on a point of the tissue [N]
  double gape = 0;     // under the stitch [m]
  lattice::StitchPhase phase = lattice::StitchPhase::kWaiting;
  double ended = 0;  // [s]
};
struct SutureMeasures {
  std::string name, wound, thread, pattern;
  double skin_force = 0;  // tension of the skin across the cut in the CT times the cut's length [N]
  std::vector<SutureSample> series;    // one per frame since the stitches were laid
  std::vector<StitchSample> stitches;  // at the end
};

SutureMeasures make_suture_measures(const World& world, const Suture& suture);
void measure_suture(const World& world, const Suture& suture, SutureMeasures& measures);

Json suture_report(const SutureMeasures& suture);
/// Warnings about stitches that tore out, broke or did not close their wound.
std::vector<std::string> suture_warnings(const World& world);

}  // namespace turgor
