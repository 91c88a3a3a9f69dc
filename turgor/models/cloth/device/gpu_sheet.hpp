// A sheet on a GPU: either law, solved by sweeps, in the wind, with holds, out of itself and of obstacles.
#pragma once

#include <memory>
#include <string>

#include "turgor/core/gpu.hpp"
#include "turgor/models/cloth/device/device_state.hpp"

namespace turgor::cloth {

/// What of these a GPU does not do: a group of a scene's keys, and a sentence; both empty = it does all.
struct Missing {
  std::string key, why;
};
Missing why_not_on_gpu(const Params& params);

/// Copies the model over, for KeptState::step_on. Error: the memory that it needs and that there is.
Result<std::shared_ptr<SheetBackend>> put(const Gpu& gpu, const Model& model);

}  // namespace turgor::cloth
