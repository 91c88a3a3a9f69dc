// A lattice that steps on a GPU: projections by colours (pbd_loops.hpp) with skin, volumes and cuts. The
// model stays there; the state goes over and comes back when it is told to, and what reads a State reads the
// host's.
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct GpuBody;

/// Can a GPU step this?
inline bool runs_on_gpu(const Params& params) {
  return params.solver.method == Method::kPbd && params.solver.schedule == Schedule::kColours;
}
/// Copies the model over. Error: the memory that it needs and that there is.
Result<std::shared_ptr<GpuBody>> put(const Gpu& gpu, const Model& model);
/// Places, velocities and cuts, over and back.
void put_state(GpuBody& body, const State& state);
void get_state(const GpuBody& body, State& state);
/// Of the state that is there, without loads; a step whose numbers are not finite is undone. The model is the
/// one that was put; its sweeps, damping and skin may be others since.
StepReport step(GpuBody& body, const Model& model, const Inputs& inputs, double dt);

/// All of that for a state that is here, as lattice::step does it on a CPU. Bodies may share `body`.
StepReport step_on_gpu(GpuBody& body, const Model& model, State& state, const Inputs& inputs, double dt);

}  // namespace turgor::lattice
