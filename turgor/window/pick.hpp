// Picking of the surface under the cursor.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "turgor/sim/snapshot.hpp"
#include "turgor/window/camera_moves.hpp"

namespace turgor {

struct Picked {
  std::size_t body = 0;              // index in WorldSnapshot::bodies
  Vec3d point, normal;               // point on the surface; unit outward normal [m]
  double distance = 0;               // from the eye [m]
  std::size_t triangle = 0;          // of the surface
  std::array<double, 3> share = {};  // barycentric coordinates in it
};

/// First triangle of a surface on a ray, from either side; the caller sets `body`.
std::optional<Picked> pick_surface(std::span<const Vec3> x, std::span<const Int3> triangles,
                                   const SightRay& ray);
/// Nearest body.
std::optional<Picked> pick(const WorldSnapshot& snapshot, const SightRay& ray);

}  // namespace turgor
