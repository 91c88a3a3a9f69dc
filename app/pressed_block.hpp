// Finite element bodies pressed by a ball, shared by the validations of sfem and rhombus.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

/// A body of one material, fixed where `is_fixed`.
sfem::Body held(SolidMesh mesh, sfem::Material material, const std::function<bool(Vec3d)>& is_fixed);

/// Builds a model with all Green's functions, or with columns on demand when the tool touches few points.
Result<sfem::Model> solved(const Exec& exec, sfem::Body body, const sfem::Params& params,
                           bool on_demand = false);

/// Patch around a touched point.
sfem::Patch patch_at(const Exec& exec, sfem::Model& model, Vec3d point, sfem::PatchParams params);

/// Presses a sphere straight down into the upper surface; returns the upward forces on it at equal steps of
/// depth.
std::vector<std::pair<double, double>> press(const sfem::Patch& patch, Vec3d point, double radius,
                                             double depth, int steps);

}  // namespace turgor
