#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {

Missing why_not_on_gpu(const Params& params) {
  if (uses_conjugate_gradients(params.solver.method))
    return {"solver", "cloth is solved by sweeps only: set solver.method = \"chebyshev\" or \"jacobi\""};
  return {};
}

}  // namespace turgor::cloth
