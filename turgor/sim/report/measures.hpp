// What a run measures: every wound over time, how the skin pulls at each cut, and what the solver left over.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// How the skin at a cut is pulled, averaged over the cut.
struct SkinPull {
  double angle = 0;       // between the cut and Langer's lines, 0…90 [degrees]
  double opening = 0;     // tension across the cut, which opens it [N/m]
  double lengthwise = 0;  // tension along the cut [N/m]
};
SkinPull skin_pull(const lattice::Model& model, const lattice::BladePath& path);

struct WoundSample {
  double time = 0;                     // [s]
  double gape_max = 0, gape_mean = 0;  // [m]
  double opening_area = 0;             // [m²]
  double edge_displacement = 0;        // [m]
};
struct CutMeasures {
  std::string name, body;
  int edges = 0;  // cut, or nodes removed
  bool region = false;
  double depth = 0, width = 0;  // as in the scene [m]
  SkinPull pull;
  std::vector<WoundSample> series;  // one a frame, since the blade started
  lattice::Wound wound;             // at the end
};

/// The solver at one snapshot.
struct SolverSample {
  double time = 0;             // [s]
  lattice::Residual residual;  // [N]
  double energy = 0;           // elastic [J]
  double largest_speed = 0;    // [m/s]
};

struct Measures {
  std::vector<CutMeasures> cuts;
  std::vector<lattice::BodySurface> near_cuts;  // drawn, of each lattice body; made anew when it is cut
  std::vector<Pressed> pressed;                 // one for every body that tools can touch
  std::vector<SolverSample> solver;
  std::vector<double> frame_seconds;  // wall time
};

Measures make_measures(const World& world);
/// After every frame; `snapshot` adds what is only measured then.
void measure_frame(const Exec& exec, const World& world, const FrameReport& frame, bool snapshot,
                   Measures& measures);

}  // namespace turgor
