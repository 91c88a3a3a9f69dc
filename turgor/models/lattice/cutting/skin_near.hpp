// The skin near a blade at its current position: directions into the body, and projection on the skin.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "turgor/models/lattice/model/halo.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

inline double largest_spacing(const Lattice& l) { return std::max({l.spacing.x, l.spacing.y, l.spacing.z}); }
/// Radius of the skin around a point whose mean normal gives the direction into the body [m].
inline double reach_of_directions(const Lattice& l) { return std::max(0.01, 3 * largest_spacing(l)); }

/// Skin triangles near a curve, for projecting the curve onto the skin and for mean normals.
SkinNow skin_near(const Model& model, const Motion& motion, const std::vector<Vec3d>& curve,
                  const HaloExchange* halo);
/// Direction into the body: the negative mean normal of the skin around the skin vertex nearest to `point`,
/// made orthogonal to `line`, which may be zero. `around` is the radius [m].
Vec3d direction_into(const SkinNow& skin, Vec3d point, Vec3d line, double around);
/// Signed distance to the nearest skin along `into`. The ray is shifted by `epsilon` to avoid corners of a
/// regular lattice. If it misses the skin, it is shifted to the other side.
std::optional<double> distance_to_skin(const SkinNow& skin, Vec3d point, Vec3d into, Vec3d epsilon);
/// Message about a point without skin near it, lattice frame.
std::string off_skin(const Model& model, const Motion& motion, const std::string& prefix, Vec3d point);

}  // namespace turgor::lattice
