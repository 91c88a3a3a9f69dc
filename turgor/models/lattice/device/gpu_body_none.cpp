// Replaces gpu_body.cu without nvcc. open_gpu then returns an error, so no Gpu exists and this is never
// called.
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor::lattice {

Result<std::shared_ptr<BodyBackend>> upload_model(const Gpu&, const Model&, Frames) {
  return open_gpu().error();
}

}  // namespace turgor::lattice
