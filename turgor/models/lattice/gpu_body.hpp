// A lattice on a GPU: either solver by colours, with skin, volumes or solid cells, cuts, loads and contacts,
// and the coarse space; nobody sleeps.
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/models/lattice/kept_state.hpp"

namespace turgor::lattice {

/// Can a GPU step this?
inline bool runs_on_gpu(const Params& params) {
  const SolverParams& solver = params.solver;
  if (solver.schedule != Schedule::kColours) return false;
  return solver.method == Method::kPbd || solver.sleep == 0;
}
/// Are the kernels of a frame told to the GPU as one graph, or one by one? The latter is for comparison.
enum class Frames { kAsGraphs, kOneByOne };
/// Copies the model over, for KeptState::step_on. Error: the memory that it needs and that there is.
Result<std::shared_ptr<BodyThere>> put(const Gpu& gpu, const Model& model, Frames frames = Frames::kAsGraphs);

}  // namespace turgor::lattice
