// State that may live on the device (core/mirrored_state.hpp). While it does, positions and velocities on the
// host are empty; holds and times are always on the host.
#pragma once

#include <span>

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

/// Sheet on the device (device_sheet.hpp): its model, and one state at a time. Uploads, steps and downloads
/// of some vertices throw OutOfDeviceMemory. A step then leaves the state unchanged, apart from BDF2's
/// history.
struct SheetBackend : BackendOf<MirroredState> {
  virtual ~SheetBackend() = default;

  /// Uploads all that a step changes, except holds and times.
  virtual void upload_state(const Model& model, const State& state) = 0;
  virtual void download_state(State& state) const = 0;
  /// Steps the state on the device, with holds and times of `state`. The model must be the uploaded one;
  /// sweeps, damping, friction and strain limit may have changed.
  virtual StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                          double frame) = 0;
  /// Downloads positions and velocities of these vertices.
  virtual void download_vertices(std::span<const int> vertices, State& state) = 0;
  /// Downloads the contacts of the latest step that load obstacles or held vertices: vertices, weights,
  /// normal and impulses.
  virtual void download_loads(const Model& model, Contacts& contacts) = 0;
};

class DeviceState : public DeviceStateOf<MirroredState> {
 public:
  DeviceState(State state = {}) : DeviceStateOf(std::move(state)) {}

  /// True if steps run on a device.
  bool has_device() const { return mirrored_->backend != nullptr; }
  /// True if positions and velocities are on the device.
  bool is_on_device() const { return mirrored_->is_on_device; }
  /// State::impulse_time, without a download.
  double impulse_time() const { return mirrored_->host_state.impulse_time; }

  /// Calls look(state) with these vertices only downloaded from a state on the device. Other vertices and the
  /// contacts are outdated, and `look` must not read them.
  template <class Look>
  auto read_vertices(std::span<const int> vertices, const Look& look) const {
    return read(nullptr, vertices, look);
  }
  /// The same, and downloads the contacts that loaded obstacles or held vertices in the latest step, with the
  /// vertices of the former.
  template <class Look>
  auto read_loads(const Model& model, std::span<const int> vertices, const Look& look) const {
    return read(&model, vertices, look);
  }

  /// Steps on the device, or on the host without a device and from the step on that lacks device memory.
  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double frame);

  /// As the functions of the same names (hold.hpp).
  Status hold(const Model& model, int mesh_vertex);
  Status move_hold(const Model& model, int mesh_vertex, Vec3 goal);
  Status release(const Model& model, int mesh_vertex);

 private:
  /// Downloaded vertices of a state on the device, and loads if a model is given. If device memory is short,
  /// the whole state moves to the host.
  struct DownloadedVertices {
    MirroredState& mirrored;
    DownloadedVertices(MirroredState& of, const Model* model, std::span<const int> vertices);
    DownloadedVertices(const DownloadedVertices&) = delete;
    DownloadedVertices& operator=(const DownloadedVertices&) = delete;
    ~DownloadedVertices() {
      if (mirrored.is_on_device) mirrored.storage.swap(mirrored.host_state);
    }
  };

  template <class Look>
  auto read(const Model* model, std::span<const int> vertices, const Look& look) const {
    if (!mirrored_->backend) return look(std::as_const(mirrored_->host_state));
    const std::lock_guard lock(mirrored_->backend->mutex);
    const DownloadedVertices downloaded(*mirrored_, model, vertices);
    return look(std::as_const(mirrored_->host_state));
  }
  StepReport step_on_device(const Exec& exec, const Model& model, const Inputs& inputs, double frame);
};

}  // namespace turgor::cloth
