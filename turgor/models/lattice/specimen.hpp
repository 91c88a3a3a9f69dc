// The piece of an excision after it left the body: its mass, and its size when nothing holds it any more.
#pragma once

#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/cutting/rim.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct Specimen {
  double volume = 0, mass = 0;  // in the CT [m³] [kg]
  OutlineSize in_place;         // of its skin before the cut, along the surface
  OutlineSize free;             // at rest without tension, pressure and weight
  double speed = 0;             // largest speed when the search for rest ended [m/s]
};

/// Takes the piece inside a complete incision out of a body, and lets a copy of it come to rest. Errors as
/// find_piece, and a rim that the lattice does not resolve.
Result<Specimen> excise_piece(const Exec& exec, const Model& model, State& state, const BladePath& path,
                              int incision);

}  // namespace turgor::lattice
