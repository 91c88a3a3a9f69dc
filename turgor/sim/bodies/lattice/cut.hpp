// Cuts of a running world: blades that advance through lattices frame by frame.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/specimen.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

struct BeforeCut;

/// Incision in progress.
struct Cut {
  lattice::Incision blade;
  int body = 0;                               // index into World::lattice_bodies
  std::optional<lattice::BladePath> path;     // computed when the blade starts
  double done = 0;                            // finished fraction of the path
  int edges = 0;                              // edges cut, or nodes removed by a static region
  std::optional<lattice::Specimen> specimen;  // of an excision, once the piece left the body
  std::shared_ptr<const BeforeCut> before;    // to undo the cut (live/undo_cut.hpp); or null
};

/// Tests the blade on the body at rest. Error: no skin below it; the message has the source location.
/// An excision gets its outline. More errors: it overlaps one of `others`, or leaves the body.
Result<Cut> load_cut(const IncisionScene& scene, const LatticeBody& body, std::span<const Cut> others = {});

/// Advances the blade of a cut to its position at a time [s]. `index`: number of the cut in cut edges. The
/// piece of a complete excision leaves the body. Errors: the blade left the skin, or a piece is not free.
/// `halo` as in lattice::Inputs.
Status advance_blade(const Exec& exec, LatticeBody& body, std::span<Cut> cuts, int index, double time,
                     const lattice::HaloExchange* halo = nullptr);

/// Smallest box around the nodes of a body, along the axes of the patient frame [m].
Box body_box(const lattice::Model& model);
/// Cut in meters from fractions of the body's box. A fraction of exactly 0 or 1 means the body's surface seen
/// from that side of the box.
lattice::Incision blade_from_fractions(const lattice::Model& model, const lattice::Incision& fractions);

}  // namespace turgor
