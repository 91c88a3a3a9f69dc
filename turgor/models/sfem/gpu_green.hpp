// Computation of the dense store of Green's functions on a GPU.
#pragma once

#include "turgor/core/gpu.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Fills the model's allocated store, of either precision. Requires the factor. The result equals that of the
/// CPU up to rounding. Error: how much GPU memory is missing.
Status fill_green_on_device(const Gpu& gpu, Model& model, const Progress& progress);

}  // namespace turgor::sfem
