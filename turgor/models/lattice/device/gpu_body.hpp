// Lattice body on a GPU: both solvers by colors, with skin, volumes or solid cells, cuts, loads, contacts and
// the coarse space. Rows never sleep on a GPU; solver.sleep is ignored.
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/models/lattice/device/device_state.hpp"

namespace turgor::lattice {

/// True if a GPU can step bodies with these parameters.
inline bool runs_on_gpu(const Params& params) { return params.solver.ordering == Ordering::kColors; }
/// Launch of a frame's kernels as CUDA graphs, or one by one for comparison.
enum class Frames { kAsGraphs, kOneByOne };
/// Uploads the model, for DeviceState::use_backend. Error: out of memory, with the required and the available
/// amount.
Result<std::shared_ptr<BodyBackend>> upload_model(const Gpu& gpu, const Model& model,
                                                  Frames frames = Frames::kAsGraphs);

}  // namespace turgor::lattice
