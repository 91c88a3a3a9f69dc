// The cuts of a scene while they happen: blades that go through lattices, frame by frame.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

/// An incision of the scene while it happens.
struct Cut {
  lattice::Incision blade;
  int body = 0;                            // index into World::lattice_bodies
  std::optional<lattice::BladePath> path;  // laid when the blade starts
  double done = 0;                         // fraction of the path that is cut
  int edges = 0;                           // edges cut, or nodes removed by a static region
};

/// Tries the blade on the body at rest. Error: it finds no skin; names the scene's place.
Result<Cut> load_cut(const IncisionScene& scene, const LatticeBody& body);

/// Moves the blade of one of a world's cuts to where it is at a time [s]. `index`: which, as cut edges
/// remember. Error: the blade found no skin any more. `others` as of lattice::Inputs.
Status advance_blade(LatticeBody& body, std::span<Cut> cuts, int index, double time,
                     const lattice::HaloExchange* halo = nullptr);

/// Smallest box around the nodes of a body, along the axes of the patient frame [m].
Box body_box(const lattice::Model& model);
/// A cut given in fractions of the body's box, in metres. A fraction that is exactly 0 or 1 means the body's
/// own surface seen from that side of the box, not the box's face.
lattice::Incision placed_blade(const lattice::Model& model, const lattice::Incision& fractions);

}  // namespace turgor
