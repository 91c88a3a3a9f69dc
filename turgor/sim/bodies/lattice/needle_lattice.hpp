// Needles of a lattice body: the resistance of its tissues, and each needle's part in the body's step
// (contact/lattice_needle.hpp).
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/lattice_needle.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct LatticeBody;

/// Tissues with a resistance of their own, and the motion of each of them by needles. Materials of
/// contact::NeedleReading are 0 for other tissue, and 1 + index of a layer.
struct NeedleLayers {
  std::vector<NeedleLayerScene> layers;
  LabelVolume labels;                   // empty: no layer with a label resists needles or has a color
  std::vector<std::vector<int>> nodes;  // of each layer: slots, ascending
  std::vector<Vec3d> before;            // mean displacement of each layer when no needle was in [m]
  std::vector<double> motion;           // largest change of it since a needle went in [m]
};

/// Resistance at a rest position, lattice frame.
contact::NeedleTissue needle_tissue(const LatticeBody& body, Vec3d rest);

/// Needles outside of the body, one for each tool, and the nodes of the layers. Does nothing without a
/// needle.
void begin_needles(LatticeBody& body);
bool has_needles(const LatticeBody& body);

/// Springs of the needles in one substep, together with those of the sutures. Moves the needles to the body's
/// present poses.
struct NeedleSprings {
  LatticeBody& body;
  lattice::PointSprings* stitches;
  lattice::PointSprings springs;
  std::shared_ptr<const lattice::Fragments> fragments;
  std::vector<contact::LatticeNeedle> before;  // to restore them if the step is undone

  /// `stitches` may be null.
  NeedleSprings(LatticeBody& body, lattice::PointSprings* stitches);
  NeedleSprings(const NeedleSprings&) = delete;
  NeedleSprings& operator=(const NeedleSprings&) = delete;
  /// Springs for lattice::Inputs.
  lattice::PointSprings* input();
  /// After the substep: forces of the needles; an undone one leaves them as they were.
  void finish(bool is_finite);

 private:
  contact::NeedleSurroundings surroundings() const;
  void refresh(const lattice::State& state);
};

/// Sets the forces of the needles among the body's tools.
void read_needle_forces(LatticeBody& body);
/// Measures the motion of the layers, after a frame.
void measure_targets(LatticeBody& body);
/// Adds a needle's part of a sample, and its work to the tool.
void add_needle(const LatticeBody& body, std::size_t t, ForceSample& sample, TouchingTool& tool);

}  // namespace turgor
