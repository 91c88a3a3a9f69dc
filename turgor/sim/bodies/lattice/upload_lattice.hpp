// Upload of a lattice body to the GPU, whose kernels then step it.
#pragma once

#include "turgor/core/result.hpp"

namespace turgor {

struct LatticeBody;

/// Uploads model and state, and notes the device. Error: no GPU, or one that cannot step this model.
Status upload_to_gpu(LatticeBody& body);
/// Uploads a model that has changed, with its state. Without the memory, the body steps on the host, and a
/// note says so.
void upload_changed_model(LatticeBody& body);

}  // namespace turgor
