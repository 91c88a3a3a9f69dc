#include "turgor/models/cloth/device/device_state.hpp"

namespace turgor::cloth {

StepReport DeviceState::step(const Exec& exec, const Model& model, const Inputs& inputs, double frame) {
  if (!kept_->there) return cloth::step(exec, model, kept_->state, inputs, frame);
  const std::lock_guard lock(kept_->there->in_use);
  claim(kept_);
  if (kept_->changed != Changed::kNothing) kept_->there->put_state(model, kept_->state);
  kept_->changed = Changed::kNothing;
  kept_->go();
  const StepReport report = kept_->there->step(exec, model, kept_->state, inputs, frame);
  kept_->update_views();
  return report;
}

Status DeviceState::hold(const Model& model, int mesh_vertex) {
  return cloth::hold(model, kept_->on_host(), mesh_vertex);
}
Status DeviceState::move_hold(const Model& model, int mesh_vertex, Vec3 goal) {
  return cloth::move_hold(model, kept_->state, mesh_vertex, goal);
}
Status DeviceState::release(const Model& model, int mesh_vertex) {
  return cloth::release(model, kept_->state, mesh_vertex);
}

}  // namespace turgor::cloth
