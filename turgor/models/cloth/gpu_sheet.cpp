#include "turgor/models/cloth/gpu_sheet.hpp"

#include "turgor/core/number_text.hpp"

namespace turgor::cloth {

Missing why_not_on_gpu(const Params& params, bool has_obstacles) {
  if (uses_gradients(params.solver.method))
    return {"solver", "sweeps alone solve cloth: set solver.method = \"chebyshev\" or \"jacobi\""};
  if (has_obstacles) return {"obstacle", "cloth stays out of itself alone: leave obstacle away"};
  return {};
}

std::string why_too_coarse(const Model& model) {
  if (model.coarse.triangles.empty()) return {};
  return "a GPU keeps layers apart by their vertices, and " + std::to_string(model.coarse.triangles.size()) +
         " triangles have edges longer than 1.5 of collision.thickness: expected a thickness of at least " +
         number_text(double(model.coarse.longest) / 1.5) + " m, smaller triangles, or collision.self = false";
}

}  // namespace turgor::cloth
