// The skin of the CT above the outermost nodes. A body's tension acts in its outermost nodes. The skin that
// the CT shows, the level set of air, lies up to a spacing farther out. Excisions are as deep below the
// latter. With partial cells, the latter bears: outlines of excisions and stitches lie on it.
#pragma once

#include <vector>

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Heights of the CT's skin above points on the skin of the nodes, against the directions into the body [m].
/// Points are at their current positions, lattice frame [m]; `inward` has a unit vector for each. A height is
/// 0 where the level set is not found within two spacings. With partial cells, these are heights of the
/// patches of skin.
std::vector<double> ct_skin_heights(const Model& model, const State& state, const std::vector<Vec3d>& points,
                                    const std::vector<Vec3d>& inward);

/// Heights of the skin of partial cells above points of the CT, lattice frame [m]; 0 without patches near.
std::vector<double> patch_heights(const Model& model, const std::vector<Vec3d>& points,
                                  const std::vector<Vec3d>& inward);

/// Points of the CT, lattice frame [m]. Those less than a spacing below the skin of partial cells move up to
/// it; the others stay.
std::vector<Vec3d> lifted_to_patches(const Model& model, const std::vector<Vec3d>& points);

}  // namespace turgor::lattice
