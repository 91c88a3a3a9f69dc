// Upload of a cloth to the GPU, whose kernels then step it.
#pragma once

#include "turgor/core/result.hpp"

namespace turgor {

struct ClothBody;

/// Uploads model and state, and notes the device. Error: no GPU, or memory is short.
Status upload_to_gpu(ClothBody& body);
/// Uploads a model that has changed, with its state. Without the memory, the cloth steps on the host, and a
/// note says so.
void upload_changed_model(ClothBody& body);

}  // namespace turgor
