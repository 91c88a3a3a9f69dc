// Tool shapes as rigid obstacles of a cloth.
#pragma once

#include "turgor/contact/tool.hpp"
#include "turgor/models/cloth/cloth.hpp"

namespace turgor::contact {

/// Obstacle for a step in which the shape moves from one pose to another. The obstacle keeps a reference to
/// the shape, which must outlive it.
cloth::Obstacle cloth_obstacle(const Shape& shape, const Pose& from, const Pose& to, double dt);
/// The same obstacle with additional contacts inside triangles. A small or fast tool therefore cannot slip
/// between vertices.
cloth::Obstacle cloth_tool(const Shape& shape, const Pose& from, const Pose& to, double dt);

}  // namespace turgor::contact
