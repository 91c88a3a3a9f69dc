// What lies under the cursor.
#pragma once

#include <optional>
#include <span>

#include "turgor/sim/snapshot.hpp"
#include "turgor/window/camera_moves.hpp"

namespace turgor {

struct Picked {
  std::size_t body = 0;  // of ShownWorld::bodies
  Vec3d point, normal;   // on it; unit, outward [m]
  double distance = 0;   // from the eye [m]
};

/// The first triangle of a surface on a ray, from either side; `body` is the caller's.
std::optional<Picked> pick_surface(std::span<const Vec3> x, std::span<const Int3> triangles,
                                   const SightRay& ray);
/// The nearest body.
std::optional<Picked> pick(const WorldSnapshot& snapshot, const SightRay& ray);

}  // namespace turgor
