// In place of gpu_sheet.cu where there is no nvcc: open_gpu has no Gpu to give, so nothing comes here.
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {

Result<std::shared_ptr<SheetBackend>> put(const Gpu&, const Model&) { return open_gpu().error(); }

}  // namespace turgor::cloth
