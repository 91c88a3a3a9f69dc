// Which vertices of a body are held, and which elements are of which material: what a scene says about a
// body, said to its mesh.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// 1 for every point that is held, of a body whose box is that around the points.
std::vector<std::uint8_t> held_points(std::span<const Vec3d> points, const HeldBy& held);
/// Error: `held` names a box, and holds none of the points; says where they are.
Status check_held(std::span<const Vec3d> points, const HeldBy& held, const std::vector<std::uint8_t>& fixed);

/// The mesh with its materials and what holds it. Error: an `inside` whose label no element has (the message
/// says which there are), or an inclusion that no element lies in.
Result<sfem::Body> make_body(SolidMesh mesh, const SfemScene& scene);

}  // namespace turgor
