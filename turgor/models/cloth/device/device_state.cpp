#include "turgor/models/cloth/device/device_state.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/hold.hpp"

namespace turgor::cloth {

StepReport DeviceState::step(const Exec& exec, const Model& model, const Inputs& inputs, double frame) {
  if (!mirrored_->backend) return cloth::step(exec, model, mirrored_->host_state, inputs, frame);
  TURGOR_ASSERT(inputs.springs.empty(), "springs of vertices act on the host");
  const std::lock_guard lock(mirrored_->backend->mutex);
  claim_backend(mirrored_);
  if (mirrored_->changed != Changed::kNothing) mirrored_->backend->upload_state(model, mirrored_->host_state);
  mirrored_->changed = Changed::kNothing;
  mirrored_->move_to_device();
  const StepReport report = mirrored_->backend->step(exec, model, mirrored_->host_state, inputs, frame);
  mirrored_->download_if_watched();
  return report;
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
