// Smooth surface of a body's snapshot.
#pragma once

#include <memory>
#include <span>

#include "turgor/geometry/loop_subdivision.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Smooth surface over a body's triangles, made once and kept in the snapshot's cache. Null for a mesh that
/// is fine enough to be drawn as it is; BodySnapshot::smooth is then empty.
std::shared_ptr<const SmoothSurface> smooth_for_drawing(std::span<const Int3> triangles, BodySnapshot& body);

/// Sets triangles, positions and normals; displacements are set.
void place_smooth(const SmoothSurface& surface, std::span<const Vec3> rest, SmoothSnapshot& smooth);

}  // namespace turgor
