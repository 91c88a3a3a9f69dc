// A tool's shape as something that a cloth stays out of.
#pragma once

#include "turgor/contact/tool.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::contact {

/// The shape at the beginning of a step in which it goes from one pose to another. Refers to the shape.
cloth::Obstacle cloth_obstacle(const Shape& shape, const Pose& from, const Pose& to, double dt);
/// The same, however small the shape is and however fast: it cannot pass between vertices either.
cloth::Obstacle cloth_tool(const Shape& shape, const Pose& from, const Pose& to, double dt);

}  // namespace turgor::contact
