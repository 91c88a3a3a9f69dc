// Bodies of finite elements that a ball is pressed into: what experiments on sfem, and on what is fitted to
// it, have in common.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

/// Of one material, held where `is_fixed`.
sfem::Body held(SolidMesh mesh, sfem::Material material, const std::function<bool(Vec3d)>& is_fixed);

/// With all Green's functions, or, when only a few places are touched, with columns on demand.
Result<sfem::Model> solved(const Exec& exec, sfem::Body body, const sfem::Params& params,
                           bool on_demand = false);

/// The finer mesh around a place.
sfem::Patch patch_at(const Exec& exec, sfem::Model& model, Vec3d place, sfem::PatchParams params);

/// Presses a sphere straight down into the upper surface; upward forces on it at equal steps of depth.
std::vector<std::pair<double, double>> press(const sfem::Patch& patch, Vec3d place, double radius,
                                             double depth, int steps);

}  // namespace turgor
