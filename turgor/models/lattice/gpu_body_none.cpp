// In place of gpu_body.cu where there is no nvcc: open_gpu has no Gpu to give, so nothing comes here.
#include "turgor/models/lattice/gpu_body.hpp"

namespace turgor::lattice {

struct GpuBody {};

Result<std::shared_ptr<GpuBody>> put(const Gpu&, const Model&) { return open_gpu().error(); }
void put_state(GpuBody&, const State&) {}
void get_state(const GpuBody&, State&) {}
StepReport step(GpuBody&, const Model&, const Inputs&, double) { return {.finite = false}; }
StepReport step_on_gpu(GpuBody&, const Model&, State&, const Inputs&, double) { return {.finite = false}; }

}  // namespace turgor::lattice
