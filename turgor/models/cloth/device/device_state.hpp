// A State and where it is (core/mirrored_state.hpp): while it steps on a GPU its places and velocities here
// are empty. Holds and times are always here.
#pragma once

#include "turgor/core/mirrored_state.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Places and velocities of a state that is away.
struct AwayStorage {
  Vectors x, v, last_x, last_v;

  void swap(State& state) {
    std::swap(x, state.x), std::swap(v, state.v);
    std::swap(last_x, state.last.x), std::swap(last_v, state.last.v);
  }
};
struct SheetBackend;
using MirroredState = Mirrored<State, SheetBackend, AwayStorage>;

/// A sheet on the other side of a bus (device_sheet.hpp): its model, and one state at a time.
struct SheetBackend : BackendOf<MirroredState> {
  virtual ~SheetBackend() = default;

  /// What changes, but for holds and times.
  virtual void put_state(const Model& model, const State& state) = 0;
  virtual void get_state(State& state) const = 0;
  /// Of the state that is there, with the holds and times of this one. The model is the one that was put; its
  /// sweeps, damping, friction and strain limit may be others since.
  virtual StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                          double frame) = 0;
};

class DeviceState : public DeviceStateOf<MirroredState> {
 public:
  DeviceState(State state = {}) : DeviceStateOf(std::move(state)) {}

  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double frame);

  /// What the functions of these names do (cloth.hpp).
  Status hold(const Model& model, int mesh_vertex);
  Status move_hold(const Model& model, int mesh_vertex, Vec3 goal);
  Status release(const Model& model, int mesh_vertex);
};

}  // namespace turgor::cloth
