// Smooth surface of a body's snapshot.
#pragma once

#include <span>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/loop_subdivision.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Sets the triangles of the body's mesh, of vertices of the snapshot, and discards the smooth surface over
/// them. They may be covered by finer triangles, whose additional vertices have no mesh vertex (mesh_vertex
/// −1).
void set_coarse(std::span<const Int3> triangles, BodySnapshot& body);

/// Makes the smooth surface over SmoothSnapshot::coarse, for those who draw the snapshot. It is displaced
/// like the points of the snapshot's surface on which it lies before smoothing. The subdivision is made once
/// and kept in the snapshot's cache. Without coarse triangles, or with a mesh that is fine enough, there is
/// none. `most`: triangles of a body that can be drawn in time.
void show_smooth(BodySnapshot& body, std::size_t most = kMostInPictures, const Exec& exec = Exec(1));
void show_smooth(WorldSnapshot& snapshot, std::size_t most = kMostInPictures, const Exec& exec = Exec(1));

}  // namespace turgor
