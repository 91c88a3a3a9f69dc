// A lattice on a GPU: either solver by colours, with skin, volumes or solid cells, cuts, loads and contacts,
// and the coarse space. Nobody sleeps there, whatever solver.sleep allows.
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/models/lattice/device/device_state.hpp"

namespace turgor::lattice {

/// Can a GPU step this?
inline bool runs_on_gpu(const Params& params) { return params.solver.ordering == Ordering::kColors; }
/// Are the kernels of a frame told to the GPU as one graph, or one by one? The latter is for comparison.
enum class Frames { kAsGraphs, kOneByOne };
/// Copies the model over, for KeptState::step_on. Error: the memory that it needs and that there is.
Result<std::shared_ptr<BodyBackend>> put(const Gpu& gpu, const Model& model,
                                         Frames frames = Frames::kAsGraphs);

}  // namespace turgor::lattice
