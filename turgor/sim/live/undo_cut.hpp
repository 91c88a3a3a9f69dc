// Undo of cuts: a copy of the body's state from before a cut is kept with the cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/model/params.hpp"
#include "turgor/models/lattice/model/state.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor {

struct LatticeBody;
struct World;

/// Progress of another cut when a cut starts.
struct CutProgress {
  bool has_path = false;
  double done = 0;  // as Cut
  int edges = 0;
};
/// A body before a cut, and the progress of all earlier cuts of the world, in their order.
struct BeforeCut {
  lattice::State state;
  double stiffness_scale = 1;     // of the body
  lattice::TissueParams tissue;   // of the body
  std::vector<Real> cell_moduli;  // of the cells of its cut-cell elements [Pa]
  std::vector<CutProgress> cuts;
  std::vector<std::optional<lattice::WoundClosure>> closures;  // of all sutures of the world
  contact::LatticeTouch touch;  // its samples are those of the surface at that time
};

/// Copy of the body's state for a cut that is about to start. Older copies are dropped, so that all of them
/// need at most kCopiedBytes. Null: the state alone is larger.
std::shared_ptr<const BeforeCut> state_before_cut(World& world, const LatticeBody& body);
constexpr std::size_t kCopiedBytes = std::size_t(1) << 30;

/// Removes the latest cut and restores its body. Positions, velocities and stitches are those from before the
/// cut; the body settles from there, and tools release it. Blades of earlier cuts that moved meanwhile cut
/// again in the next frame. Error: its copy was dropped.
Status undo_last_cut(World& world);

}  // namespace turgor
