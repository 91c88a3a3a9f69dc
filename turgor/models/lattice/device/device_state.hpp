// Lattice state that steps on the host or on a device (core/mirrored_state.hpp). While it is on a device, its
// host positions and velocities are empty.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "turgor/core/mirrored_state.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::lattice {

/// Host memory of the positions and velocities of a state on the device.
struct DeviceStateStorage {
  VecField u, u_before, v;

  void swap(State& state) {
    Motion& motion = state.motion;
    std::swap(u, motion.u), std::swap(u_before, motion.u_before), std::swap(v, motion.v);
  }
};
struct BodyBackend;
using MirroredState = Mirrored<State, BodyBackend, DeviceStateStorage>;

/// Immutable samples in device memory, freed with the last reference.
struct DeviceSamples {
  virtual ~DeviceSamples() = default;
  virtual const std::int16_t* data() const = 0;  // device pointer
  /// Downloads all samples.
  virtual void download(std::span<std::int16_t> samples) const = 0;
};
/// Resampled CT in device memory [HU].
struct DeviceResampled {
  Grid grid;
  std::shared_ptr<const DeviceSamples> samples;
  ResampleReport report;
};

/// Body in device memory (device_body.hpp): its model, and one state at a time. Uploads, steps and downloads
/// of some nodes throw OutOfDeviceMemory; a step then leaves the state unchanged.
struct BodyBackend : BackendOf<MirroredState> {
  virtual ~BodyBackend() = default;

  virtual void upload_state(const Model& model, const State& state) = 0;
  /// Uploads the cuts of a state with their elements and virtual nodes, without the motion of other nodes.
  virtual void upload_cuts(const Model& model, const Cuts& cuts, const CutElements& elements,
                           std::span<const VirtualNodeDisplacement> virtual_u,
                           std::span<const VirtualNodeDisplacement> virtual_u_before) = 0;
  /// Downloads positions and velocities of all nodes and virtual nodes.
  virtual void download_state(State& state) const = 0;
  /// Downloads positions and velocities of these nodes.
  virtual void download_nodes(std::span<const int> slots, Motion& motion) = 0;
  /// Downloads Motion::virtual_u.
  virtual void download_virtual_nodes(Motion& motion) const = 0;
  /// samples_in_balls on the device. A change of `version` uploads the samples again.
  virtual std::vector<int> find_samples(std::span<const SurfaceSample> samples, std::uint64_t version,
                                        std::span<const Ball> balls) = 0;
  /// Steps the state on the device; a step with nonfinite values is undone. The model is the one uploaded at
  /// construction, but its sweeps, damping and skin may have changed. `elements` are those of the uploaded
  /// cuts. `coarse` is null without the coarse correction (prepare_coarse_space). `fastest` is
  /// Motion::fastest before the step.
  virtual StepReport step(const Model& model, const CutElements& elements,
                          const std::shared_ptr<const CoarseSpace>& coarse, Real fastest,
                          const Inputs& inputs, double dt) = 0;
  /// resample_ct with the result in device memory; empty if memory is short. `cuts` are those of the state on
  /// the device. `ct` is the CT that the body was built from.
  virtual std::optional<DeviceResampled> resample(const Exec& exec, const Model& model, const Cuts& cuts,
                                                  const CtVolume& ct, const Grid& grid,
                                                  const ResampleOptions& options) = 0;
  /// Fields of resample_displacement and resample_jacobian. Returns false if memory is short.
  virtual bool download_displacement(const Model& model, const Cuts& cuts, const Grid& grid,
                                     std::span<Vec3> samples) = 0;
  virtual bool download_jacobian(const Model& model, const Cuts& cuts, const Grid& grid,
                                 std::span<float> samples) = 0;
  /// Uploads the prestress of the present cut elements.
  virtual void upload_prestress(const Model& model, const CutElements& elements) = 0;
  /// download_state without virtual nodes.
  virtual void download_motion(Motion& motion) const = 0;
};

class DeviceState : public DeviceStateOf<MirroredState> {
 public:
  DeviceState(State state = {}) : DeviceStateOf(std::move(state)) {}

  /// Current cuts, without a download.
  const Cuts& cuts() const { return mirrored_->host_state.cuts; }
  /// Elements of the current cuts, without a download.
  const CutElements& cut_elements() const { return mirrored_->host_state.cut_elements; }
  /// Motion::virtual_u, without a download. The number of virtual nodes is current. While the state is on the
  /// device, the values may be outdated.
  std::span<const VirtualNodeDisplacement> virtual_u() const {
    return mirrored_->host_state.motion.virtual_u;
  }
  /// True if positions and velocities are on the device.
  bool is_on_device() const { return mirrored_->is_on_device; }
  /// True if steps run on a device.
  bool has_device() const { return mirrored_->backend != nullptr; }
  /// Calls look(state) with these nodes only downloaded from a state on the device. Other nodes are outdated,
  /// and `look` must not read them.
  template <class Look>
  auto read_nodes(std::span<const int> nodes, const Look& look) const {
    return read_nodes(nodes, false, look);
  }
  /// The same, and downloads the virtual nodes as well, for drawing and measuring wounds.
  template <class Look>
  auto read_wound_nodes(std::span<const int> nodes, const Look& look) const {
    return read_nodes(nodes, true, look);
  }
  /// samples_in_balls on host or device. A change of `version` uploads the samples again.
  std::vector<int> samples_in_balls(std::span<const SurfaceSample> samples, std::uint64_t version,
                                    std::span<const Ball> balls) const;

  /// Steps on the device, or on the host without a device and from the step on that lacks device memory.
  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double dt);

  /// Wakes all rows, without a transfer.
  void wake() { mirrored_->host_state.sleep = {}; }
  /// Same as the function of this name in cut_topology.hpp.
  void renew_prestress(const Model& model);

  /// Same as the functions of these names in incision.hpp.
  int cut_edges(const Model& model, const BladePath& path, double begin, double end, int incision);
  int cut_region(const Model& model, const BladePath& path);
  /// Same as resample_ct and the functions of these names in resample.hpp, on host or device.
  ResampledCt resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                       const ResampleOptions& options = {}) const;
  VectorVolume resample_displacement(const Exec& exec, const Model& model, const Grid& grid) const;
  ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const Grid& grid) const;
  /// Resampled CT in device memory, for pictures rendered on the device. Empty if the state is on the host or
  /// if device memory is short.
  std::optional<DeviceResampled> resample_on_device(const Exec& exec, const Model& model, const CtVolume& ct,
                                                    const Grid& grid, const ResampleOptions& options) const;

 private:
  /// Downloaded nodes of a state on the device, valid during this object's lifetime.
  struct DownloadedNodes {
    MirroredState& mirrored;
    DownloadedNodes(MirroredState& of, std::span<const int> nodes, bool virtual_nodes) : mirrored(of) {
      if (!mirrored.is_on_device) return;
      mirrored.storage.swap(mirrored.host_state);
      if (virtual_nodes) mirrored.backend->download_virtual_nodes(mirrored.host_state.motion);
      add(nodes);
    }
    /// Downloads further nodes. If device memory is short, the whole state moves to the host.
    void add(std::span<const int> nodes);
    DownloadedNodes(const DownloadedNodes&) = delete;
    DownloadedNodes& operator=(const DownloadedNodes&) = delete;
    ~DownloadedNodes() {
      if (mirrored.is_on_device) mirrored.storage.swap(mirrored.host_state);
    }
  };

  template <class Look>
  auto read_nodes(std::span<const int> nodes, bool virtual_nodes, const Look& look) const {
    if (!mirrored_->backend) return look(std::as_const(mirrored_->host_state));
    const std::lock_guard lock(mirrored_->backend->mutex);
    const DownloadedNodes downloaded(*mirrored_, nodes, virtual_nodes);
    return look(std::as_const(mirrored_->host_state));
  }
  StepReport step_on_device(const Exec& exec, const Model& model, const Inputs& inputs, double dt);
  template <class Cut>
  int cut_with(State& state, const Cut& cut);
  template <class Get>
  bool download_from_device(const Get& get) const;
};

}  // namespace turgor::lattice
