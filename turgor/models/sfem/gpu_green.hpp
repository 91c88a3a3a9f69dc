// The dense store of Green's functions, made on a GPU.
#pragma once

#include "turgor/core/gpu.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Fills the store that the model has room for, of either precision; the model is factored. Error: how much
/// of the GPU's memory is lacking. What the CPU stores, but for rounding.
Status fill_green_on(const Gpu& gpu, Model& model, const Progress& progress);

}  // namespace turgor::sfem
