#include "turgor/models/lattice/device/device_state.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/cutting/cut_topology.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

namespace {

/// Makes this state current on the device.
void upload_changes(const Model& model, const std::shared_ptr<MirroredState>& mirrored) {
  claim_backend(mirrored);
  if (mirrored->changed == Changed::kAll) mirrored->backend->upload_state(model, mirrored->host_state);
  if (mirrored->changed == Changed::kPartial) {
    const State& state = mirrored->host_state;
    mirrored->backend->upload_cuts(model, state.cuts, state.cut_elements, state.motion.virtual_u,
                                   state.motion.virtual_u_before);
  }
  mirrored->changed = Changed::kNothing;
}

/// True if the device holds this state's current values, downloaded or not.
bool is_current_on_device(const std::shared_ptr<MirroredState>& mirrored) {
  return mirrored->backend->owner.lock() == mirrored && mirrored->changed == Changed::kNothing;
}

}  // namespace

void DeviceState::DownloadedNodes::add(std::span<const int> nodes) {
  State& state = mirrored.host_state;
  if (!mirrored.is_on_device) return;
  try {
    mirrored.backend->download_nodes(nodes, state.motion);
  } catch (const OutOfDeviceMemory&) {
    mirrored.backend->download_state(state);
    mirrored.is_on_device = false;
  }
}

std::vector<int> DeviceState::samples_in_balls(std::span<const SurfaceSample> samples, std::uint64_t version,
                                               std::span<const Ball> balls) const {
  const State& state = mirrored_->host_state;
  if (!mirrored_->backend) return lattice::samples_in_balls(samples, state.motion, balls);
  const std::lock_guard lock(mirrored_->backend->mutex);
  if (mirrored_->is_on_device) {
    try {
      return mirrored_->backend->find_samples(samples, version, balls);
    } catch (const OutOfDeviceMemory&) {
      mirrored_->move_to_host();
    }
  }
  return lattice::samples_in_balls(samples, state.motion, balls);
}

StepReport DeviceState::step_on_device(const Exec& exec, const Model& model, const Inputs& inputs,
                                       double dt) {
  // upload changes of the host
  upload_changes(model, mirrored_);
  mirrored_->move_to_device();
  // step on the device
  State& state = mirrored_->host_state;
  const bool use_coarse_space =
      inputs.contacts.empty() && prepare_coarse_space(model, state, inputs, dt, exec);
  const StepReport report =
      mirrored_->backend->step(model, state.cut_elements, use_coarse_space ? state.workspace.coarse : nullptr,
                               state.motion.fastest, inputs, dt);
  // update the host's time and fastest speed
  state.motion.fastest = report.largest_speed;
  if (report.finite) state.motion.time += dt;
  mirrored_->download_if_watched();
  return report;
}

StepReport DeviceState::step(const Exec& exec, const Model& model, const Inputs& inputs, double dt) {
  TURGOR_ASSERT(is_step_length(dt), "a step has a positive length");
  const std::shared_ptr<BodyBackend> backend = mirrored_->backend;
  if (backend) {
    TURGOR_ASSERT(inputs.springs == nullptr && inputs.points == nullptr,
                  "springs and contacts at points need a body on the host");
    const std::lock_guard lock(backend->mutex);
    try {
      return step_on_device(exec, model, inputs, dt);
    } catch (const OutOfDeviceMemory&) {
      mirrored_->leave_device();
    }
  }
  return lattice::step(exec, model, mirrored_->host_state, inputs, dt);
}

std::optional<DeviceResampled> DeviceState::resample_on_device(const Exec& exec, const Model& model,
                                                               const CtVolume& ct, const Grid& grid,
                                                               const ResampleOptions& options) const {
  if (!mirrored_->backend) return {};
  const Timer timer;
  const std::lock_guard lock(mirrored_->backend->mutex);
  if (!is_current_on_device(mirrored_)) return {};
  std::optional<DeviceResampled> now =
      mirrored_->backend->resample(exec, model, mirrored_->host_state.cuts, ct, grid, options);
  if (now) now->report.seconds = timer.seconds();
  return now;
}

ResampledCt DeviceState::resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                                  const ResampleOptions& options) const {
  const Timer timer;
  const auto on_device = resample_on_device(exec, model, ct, grid, options);
  if (!on_device) return resample_ct(exec, model, host(), ct, grid, options);
  ResampledCt now{.ct = {.grid = on_device->grid, .samples = {}}, .report = on_device->report};
  now.ct.samples.resize(sample_count(grid));
  on_device->samples->download(now.ct.samples);
  now.report.seconds = timer.seconds();
  return now;
}

/// Returns false if the state is not current on the device, or if device memory is short.
template <class Get>
bool DeviceState::download_from_device(const Get& get) const {
  if (!mirrored_->backend) return false;
  const std::lock_guard lock(mirrored_->backend->mutex);
  return is_current_on_device(mirrored_) && get(*mirrored_->backend);
}

VectorVolume DeviceState::resample_displacement(const Exec& exec, const Model& model,
                                                const Grid& grid) const {
  VectorVolume field{.grid = grid, .samples = std::vector<Vec3>(sample_count(grid))};
  if (download_from_device([&](BodyBackend& backend) {
        return backend.download_displacement(model, mirrored_->host_state.cuts, grid, field.samples);
      }))
    return field;
  return lattice::resample_displacement(exec, model, host(), grid);
}

ScalarVolume DeviceState::resample_jacobian(const Exec& exec, const Model& model, const Grid& grid) const {
  ScalarVolume field{.grid = grid, .samples = std::vector<float>(sample_count(grid))};
  if (download_from_device([&](BodyBackend& backend) {
        return backend.download_jacobian(model, mirrored_->host_state.cuts, grid, field.samples);
      }))
    return field;
  return lattice::resample_jacobian(exec, model, host(), grid);
}

template <class Cut>
int DeviceState::cut_with(State& state, const Cut& cut) {
  const std::size_t before = cut_version(state.cuts);
  const int count = cut(state);
  if (count > 0 || cut_version(state.cuts) != before)
    mirrored_->changed = std::max(mirrored_->changed, Changed::kPartial);
  return count;
}

/// A state on the device is not moved to the host. Virtual nodes are downloaded, and the nodes from which new
/// ones are interpolated. The cut topology is uploaded at once; without the memory, the state leaves the
/// device.
int DeviceState::cut_edges(const Model& model, const BladePath& path, double begin, double end,
                           int incision) {
  const auto cut = [&](const DownloadNodes& download) {
    return cut_with(mirrored_->host_state, [&](State& state) {
      return lattice::cut_edges(model, state, path, begin, end, incision, download);
    });
  };
  const std::shared_ptr<BodyBackend> backend = mirrored_->backend;
  if (!backend) return cut({});
  const std::lock_guard lock(backend->mutex);
  if (!mirrored_->is_on_device) return cut({});
  // cut with the nodes that it reads
  int count = 0;
  {
    DownloadedNodes downloaded(*mirrored_, {}, true);
    count = cut([&](std::span<const int> nodes) { downloaded.add(nodes); });
  }
  // upload the cut; without the memory, positions join its virtual nodes on the host
  try {
    upload_changes(model, mirrored_);
  } catch (const OutOfDeviceMemory&) {
    if (std::exchange(mirrored_->is_on_device, false)) {
      mirrored_->storage.swap(mirrored_->host_state);
      backend->download_motion(mirrored_->host_state.motion);
    }
    mirrored_->leave_device();
  }
  return count;
}

/// A state that waits for its upload gets the prestress with it.
void DeviceState::renew_prestress(const Model& model) {
  State& state = mirrored_->host_state;
  if (!mirrored_->backend) return lattice::renew_prestress(model, state.cuts, state.cut_elements);
  const std::lock_guard lock(mirrored_->backend->mutex);
  lattice::renew_prestress(model, state.cuts, state.cut_elements);
  if (is_current_on_device(mirrored_)) mirrored_->backend->upload_prestress(model, state.cut_elements);
}

int DeviceState::cut_region(const Model& model, const BladePath& path) {
  return cut_with(mirrored_->on_host(),
                  [&](State& state) { return lattice::cut_region(model, state, path); });
}

}  // namespace turgor::lattice
