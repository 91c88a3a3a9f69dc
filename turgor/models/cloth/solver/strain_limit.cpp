#include "turgor/models/cloth/solver/strain_limit.hpp"

#include "turgor/models/cloth/solver/motion_kernels.hpp"

namespace turgor::cloth {

void limit_strain(const Exec& exec, const Model& model, State& state, double dt) {
  for (int pass = 0; pass < kStrainPasses; pass++) {
    parallel_for(exec, batch_count(model.rows),
                 LimitStrain<Lanes>{view(model, state), strain_limit(model), Real(dt)}, 16);
    std::swap(state.v, state.system.previous);
  }
}

}  // namespace turgor::cloth
