// State that may live on the device (core/mirrored_state.hpp). While it does, positions and velocities on the
// host are empty; holds and times are always on the host.
#pragma once

#include "turgor/core/mirrored_state.hpp"
#include "turgor/models/cloth/step.hpp"

namespace turgor::cloth {

/// Positions and velocities that are set aside while the state is on the device.
struct DeviceStateStorage {
  Vectors x, v, history_x, history_v;

  void swap(State& state) {
    std::swap(x, state.x), std::swap(v, state.v);
    std::swap(history_x, state.history.x), std::swap(history_v, state.history.v);
  }
};
struct SheetBackend;
using MirroredState = Mirrored<State, SheetBackend, DeviceStateStorage>;

/// Sheet on the device (device_sheet.hpp): its model, and one state at a time.
struct SheetBackend : BackendOf<MirroredState> {
  virtual ~SheetBackend() = default;

  /// Uploads all that a step changes, except holds and times.
  virtual void upload_state(const Model& model, const State& state) = 0;
  virtual void download_state(State& state) const = 0;
  /// Steps the state on the device, with holds and times of `state`. The model must be the uploaded one;
  /// sweeps, damping, friction and strain limit may have changed.
  virtual StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                          double frame) = 0;
};

class DeviceState : public DeviceStateOf<MirroredState> {
 public:
  DeviceState(State state = {}) : DeviceStateOf(std::move(state)) {}

  bool has_device() const { return mirrored_->backend != nullptr; }
  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double frame);

  /// As the functions of the same names (hold.hpp).
  Status hold(const Model& model, int mesh_vertex);
  Status move_hold(const Model& model, int mesh_vertex, Vec3 goal);
  Status release(const Model& model, int mesh_vertex);
};

}  // namespace turgor::cloth
