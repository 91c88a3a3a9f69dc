// Smooth surface of a body's snapshot.
#pragma once

#include <span>

#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Sets BodySnapshot::smooth from the surface of a snapshot. `coarse`: triangles of the body's mesh, of
/// vertices of the snapshot; they may be covered by finer ones, whose additional vertices have no mesh vertex
/// (mesh_vertex −1). The smooth surface is displaced like the points of the snapshot's surface on which it
/// lies before smoothing. The subdivision is made once and kept in the snapshot's cache. A mesh that is fine
/// enough has none.
void show_smooth(std::span<const Int3> coarse, BodySnapshot& body);

}  // namespace turgor
