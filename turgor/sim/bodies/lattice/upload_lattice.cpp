#include "turgor/sim/bodies/lattice/upload_lattice.hpp"

#include <memory>
#include <utility>

#include "turgor/core/gpu.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

namespace {

/// Uploads model and state. Returns the GPU.
Result<Gpu> use_gpu(LatticeBody& body) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return Error{"world.device = \"gpu\": " + gpu.error().message};
  Result<std::shared_ptr<lattice::BodyBackend>> backend = upload_model(*gpu, body.model);
  if (!backend) return Error{"world.device = \"gpu\": " + backend.error().message};
  body.state.use_backend(std::move(*backend));
  return gpu;
}

}  // namespace

Status upload_to_gpu(LatticeBody& body) {
  const Result<Gpu> gpu = use_gpu(body);
  if (!gpu) return gpu.error();
  const lattice::SolverParams& solver = body.model.params.solver;
  const bool may_sleep = solver.method == lattice::Method::kVbd && solver.sleep_speed > 0;
  body.notes.push_back("steps on " + gpu->name +
                       (may_sleep ? "; rows do not sleep on a GPU, solver.sleep_speed is ignored" : ""));
  return Done{};
}

void upload_changed_model(LatticeBody& body) {
  body.state.use_backend(nullptr);  // frees the former model
  if (const Result<Gpu> gpu = use_gpu(body); !gpu)
    body.notes.push_back("steps on the host since its last change: " + gpu.error().message);
}

}  // namespace turgor
