// Deformed surface in the memory of an earlier one, for surfaces that are drawn many times a second.
#pragma once

#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {

/// deformed_surface (surface.hpp), which overwrites a mesh.
void deform_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown,
                    const Exec& exec, TriMesh& mesh);

}  // namespace turgor::lattice
