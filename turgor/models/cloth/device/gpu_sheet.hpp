// Sheet on a GPU: both laws, sweeps, wind, holds, self-collision and obstacles.
#pragma once

#include <memory>
#include <string>

#include "turgor/core/gpu.hpp"
#include "turgor/models/cloth/device/device_state.hpp"

namespace turgor::cloth {

/// Unsupported feature: group of scene keys, and a sentence; both empty if all is supported.
struct Missing {
  std::string key, why;
};
Missing why_not_on_gpu(const Params& params);

/// Uploads the model, for DeviceState::use_backend. Error: needed and available memory.
Result<std::shared_ptr<SheetBackend>> put(const Gpu& gpu, const Model& model);

}  // namespace turgor::cloth
