// Replaces gpu_sheet.cu in builds without nvcc. open_gpu returns no Gpu then, so this is not reached.
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {

Result<std::shared_ptr<SheetBackend>> put(const Gpu&, const Model&) { return open_gpu().error(); }

}  // namespace turgor::cloth
