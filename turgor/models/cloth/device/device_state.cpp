#include "turgor/models/cloth/device/device_state.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/cloth/hold.hpp"

namespace turgor::cloth {

DeviceState::DownloadedVertices::DownloadedVertices(MirroredState& of, const Model* model,
                                                    std::span<const int> vertices)
    : mirrored(of) {
  if (!mirrored.is_on_device) return;
  State& state = mirrored.host_state;
  mirrored.storage.swap(state);
  try {
    // loads, then the vertices of those on obstacles
    std::vector<int> all(vertices.begin(), vertices.end());
    if (model) {
      mirrored.backend->download_loads(*model, state.contacts);
      for (const Contact& c : state.contacts.list)
        std::copy_if(c.vertex.begin(), c.vertex.end(), std::back_inserter(all),
                     [&c](int v) { return c.obstacle >= 0 && v >= 0; });
      sort_unique(all);
    }
    mirrored.backend->download_vertices(all, state);
  } catch (const OutOfDeviceMemory&) {
    mirrored.backend->download_state(state);
    mirrored.is_on_device = false;
  }
}

StepReport DeviceState::step_on_device(const Exec& exec, const Model& model, const Inputs& inputs,
                                       double frame) {
  claim_backend(mirrored_);
  if (mirrored_->changed != Changed::kNothing) mirrored_->backend->upload_state(model, mirrored_->host_state);
  mirrored_->changed = Changed::kNothing;
  mirrored_->move_to_device();
  const StepReport report = mirrored_->backend->step(exec, model, mirrored_->host_state, inputs, frame);
  mirrored_->download_if_watched();
  return report;
}

StepReport DeviceState::step(const Exec& exec, const Model& model, const Inputs& inputs, double frame) {
  const std::shared_ptr<SheetBackend> backend = mirrored_->backend;
  if (backend) {
    TURGOR_ASSERT(inputs.springs.empty(), "springs of vertices act on the host");
    const std::lock_guard lock(backend->mutex);
    try {
      return step_on_device(exec, model, inputs, frame);
    } catch (const OutOfDeviceMemory&) {
      mirrored_->leave_device();
    }
  }
  return cloth::step(exec, model, mirrored_->host_state, inputs, frame);
}

Status DeviceState::hold(const Model& model, int mesh_vertex) {
  return cloth::hold(model, mirrored_->on_host(), mesh_vertex);
}
Status DeviceState::move_hold(const Model& model, int mesh_vertex, Vec3 goal) {
  return cloth::move_hold(model, mirrored_->host_state, mesh_vertex, goal);
}
Status DeviceState::release(const Model& model, int mesh_vertex) {
  return cloth::release(model, mirrored_->host_state, mesh_vertex);
}

}  // namespace turgor::cloth
