// In place of gpu_body.cu where there is no nvcc: open_gpu has no Gpu to give, so nothing comes here.
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor::lattice {

Result<std::shared_ptr<BodyBackend>> put(const Gpu&, const Model&, Frames) { return open_gpu().error(); }

}  // namespace turgor::lattice
