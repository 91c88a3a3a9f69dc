// Directions of the fibers of cells from a vector volume, such as the main directions of a diffusion image.
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Unit directions by slot of the cells, lattice frame: that of the sample nearest to the center of a cell.
/// Zero where the sample is zero or not finite, and outside of the image. `field` is in the patient frame.
/// Empty: no cell of the body has a direction.
std::vector<Vec3> fiber_lines(const VectorVolume& field, const Model& model);

/// Turns the fibers of cells with a direction; set_cell_laws undoes this. Does nothing without fibers or
/// directions.
void set_fiber_lines(std::span<const Vec3> lines, Model& model);

}  // namespace turgor::lattice
