// Applies fixed regions and materials of a scene to a mesh.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// 1 for every fixed point of a body whose box is that around the points.
std::vector<std::uint8_t> held_points(std::span<const Vec3d> points, const HeldBy& held);
/// Error: `held` is a box without points; the message has the extent of the points.
Status check_held(std::span<const Vec3d> points, const HeldBy& held, const std::vector<std::uint8_t>& fixed);

/// Mesh with materials and fixed vertices. Error: an `inside` label without elements (the message lists
/// existing labels), or an inclusion without elements.
Result<sfem::Body> make_body(SolidMesh mesh, const SfemScene& scene);

}  // namespace turgor
