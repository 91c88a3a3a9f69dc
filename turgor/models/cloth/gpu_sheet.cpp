#include "turgor/models/cloth/gpu_sheet.hpp"

namespace turgor::cloth {

Missing why_not_on_gpu(const Params& params, bool has_obstacles) {
  if (uses_gradients(params.solver.method))
    return {"solver", "sweeps alone solve cloth: set solver.method = \"chebyshev\" or \"jacobi\""};
  if (params.collision.self)
    return {"collision", "layers do not stay out of each other: set collision.self = false"};
  if (has_obstacles) return {"obstacle", "cloth stays out of nothing: leave obstacle away"};
  return {};
}

}  // namespace turgor::cloth
