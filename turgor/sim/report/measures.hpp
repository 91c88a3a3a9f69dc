// Measurements of a run: wounds over time, skin tension at each cut, and residuals of the solver.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/report/report_suture.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Skin tension at a cut, mean over the cut.
struct CutTension {
  double angle = 0;             // between the cut and Langer's lines, 0…90 [degrees]
  double opening = 0;           // tension across the cut, which opens it [N/m]
  double lengthwise = 0;        // tension along the cut [N/m]
  bool is_directional = false;  // tension along Langer's lines differs from that across
};
/// Expected relative error of a gape from the lattice spacing: 0.94 (spacing / depth)². It bounds the errors
/// of cuts in any orientation, with 2.5 to 5 spacings of depth (docs/validation.md, Wounds). Negative for
/// tissue laws without such measurements, and below 2 spacings of depth.
double expected_gape_error(const lattice::Model& model, double depth);
CutTension cut_tension(const lattice::Model& model, const lattice::BladePath& path);

struct WoundSample {
  double time = 0;                     // [s]
  double gape_max = 0, gape_mean = 0;  // [m]
  double opening_area = 0;             // [m²]
  double edge_displacement = 0;        // [m]
};
/// Height of the skin beyond the ends of an excised wound, above the skin of the CT [m].
struct DogEars {
  double first = 0, last = 0;
};
struct CutMeasures {
  std::string name, body;
  int edges = 0;  // edges cut, or nodes removed
  bool region = false, excision = false;
  double depth = 0, width = 0;  // as in the scene [m]
  CutTension tension;
  double gape_error = -1;       // expected from the lattice spacing, relative; -1 = unknown
  lattice::OutlineSize marked;  // of an excision, on the skin before the cut
  std::optional<lattice::Specimen> specimen;
  std::optional<DogEars> dog_ears;
  lattice::Undermining undermined;  // as in the scene
  std::vector<WoundSample> series;  // one per frame since the blade started
  lattice::Wound wound;             // at the end
};

/// Solver state at one snapshot.
struct SolverSample {
  double time = 0;             // [s]
  lattice::Residual residual;  // [N]
  double energy = 0;           // elastic [J]
  double largest_speed = 0;    // [m/s]
};

struct Measures {
  std::vector<CutMeasures> cuts;
  std::vector<SutureMeasures> sutures;
  std::vector<lattice::BodySurface> wound_surfaces;  // of each lattice body; rebuilt after each cut
  std::vector<Pressed> pressed;                      // one for every body that tools can touch
  std::vector<SolverSample> solver;
  std::vector<double> frame_seconds;  // wall time
};

Measures make_measures(const World& world);
/// After every frame; `snapshot` adds measurements of the solver.
void measure_frame(const Exec& exec, const World& world, const FrameReport& frame, bool snapshot,
                   Measures& measures);

}  // namespace turgor
