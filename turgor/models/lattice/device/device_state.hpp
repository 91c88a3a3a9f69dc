// A State and where it is (core/mirrored_state.hpp): while it steps on a GPU its places and velocities here
// are empty.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "turgor/core/mirrored_state.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::lattice {

/// Places and velocities of a state that is away.
struct AwayStorage {
  VecField u, u_before, v;

  void swap(State& state) {
    std::swap(u, state.u), std::swap(u_before, state.u_before), std::swap(v, state.v);
  }
};
struct BodyBackend;
using MirroredState = Mirrored<State, BodyBackend, AwayStorage>;

/// Samples on the other side of a bus, as long as somebody holds them. Nothing changes them.
struct DeviceSamples {
  virtual ~DeviceSamples() = default;
  virtual const std::int16_t* data() const = 0;  // there
  /// Brings all of them here.
  virtual void get(std::span<std::int16_t> samples) const = 0;
};
/// A deformed CT there [HU].
struct DeviceResampled {
  Grid grid;
  std::shared_ptr<const DeviceSamples> samples;
  ResampleReport report;
};

/// A body on the other side of a bus (device_body.hpp): its model, and one state at a time.
struct BodyBackend : BackendOf<MirroredState> {
  virtual ~BodyBackend() = default;

  virtual void put_state(const Model& model, const State& state) = 0;
  /// What a blade changes of a state: not where the nodes are and how fast.
  virtual void put_cuts(const Model& model, const State& state) = 0;
  /// Places and velocities.
  virtual void get_state(State& state) const = 0;
  /// Places and velocities of these nodes.
  virtual void get_nodes(std::span<const int> slots, State& state) = 0;
  /// State::copies.
  virtual void get_copies(State& state) const = 0;
  /// places_in. `version`: another one with other places.
  virtual std::vector<int> find_places(std::span<const SurfaceSample> places, std::uint64_t version,
                                       std::span<const Ball> balls) = 0;
  /// Of the state that is there; a step whose numbers are not finite is undone. The model is the one that was
  /// put; its sweeps, damping and skin may be others since. `known`: the state that is there, without places
  /// and velocities. `smooth`: is its coarse space to be used (prepare_coarse_space)?
  virtual StepReport step(const Model& model, const State& known, bool smooth, const Inputs& inputs,
                          double dt) = 0;
  /// What resample_ct makes, left there; nothing where there is no room for it. `cuts`: the state that is
  /// there, of which only what blades did to it is looked at. `ct` is the one that the body was built from.
  virtual std::optional<DeviceResampled> resample(const Exec& exec, const Model& model, const State& cuts,
                                                  const CtVolume& ct, const Grid& grid,
                                                  const ResampleOptions& options) = 0;
  /// What resample_displacement and resample_jacobian make. False: there is no room for it.
  virtual bool get_displacement(const Model& model, const State& cuts, const Grid& grid,
                                std::span<Vec3> samples) = 0;
  virtual bool get_jacobian(const Model& model, const State& cuts, const Grid& grid,
                            std::span<float> samples) = 0;
};

class DeviceState : public DeviceStateOf<MirroredState> {
 public:
  DeviceState(State state = {}) : DeviceStateOf(std::move(state)) {}

  /// cut_version, wherever it is.
  std::size_t cuts() const;
  /// What blades did to it, wherever it is: it may be without places and velocities.
  const State& without_places() const { return kept_->state; }
  /// Are places and velocities elsewhere at the moment?
  bool is_on_device() const { return kept_->away; }
  /// Of a state that is elsewhere, these nodes alone come back, and for look(state) alone, which asks for no
  /// others: they would be old.
  template <class Look>
  auto read_nodes(std::span<const int> nodes, const Look& look) const {
    return read_nodes(nodes, false, look);
  }
  /// The same with the copies of nodes beside blades, for what is drawn or measured of wounds.
  template <class Look>
  auto read_wound_nodes(std::span<const int> nodes, const Look& look) const {
    return read_nodes(nodes, true, look);
  }
  /// places_in, wherever it is. `version`: another one with other places.
  std::vector<int> places_in(std::span<const SurfaceSample> places, std::uint64_t version,
                             std::span<const Ball> balls) const;

  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double dt);

  /// What the functions of these names do (incision.hpp).
  int cut_edges(const Model& model, const BladePath& path, double begin, double end, int incision);
  int cut_region(const Model& model, const BladePath& path);
  /// resample_ct, and what the functions of these names make (resample.hpp), where the state is.
  ResampledCt resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                       const ResampleOptions& options = {}) const;
  VectorVolume resample_displacement(const Exec& exec, const Model& model, const Grid& grid) const;
  ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const Grid& grid) const;
  /// The deformed CT where the state is elsewhere, for pictures that are drawn there. Nothing: it is here, or
  /// there is no room.
  std::optional<DeviceResampled> resample_there(const Exec& exec, const Model& model, const CtVolume& ct,
                                                const Grid& grid, const ResampleOptions& options) const;

 private:
  /// Some nodes of a state that is away, for as long as this lives.
  struct Borrowed {
    MirroredState& kept;
    Borrowed(MirroredState& whose, std::span<const int> nodes, bool virtual_nodes) : kept(whose) {
      if (!kept.away) return;
      kept.room.swap(kept.state);
      kept.there->get_nodes(nodes, kept.state);
      if (virtual_nodes) kept.there->get_copies(kept.state);
    }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    ~Borrowed() {
      if (kept.away) kept.room.swap(kept.state);
    }
  };

  template <class Look>
  auto read_nodes(std::span<const int> nodes, bool virtual_nodes, const Look& look) const {
    if (!kept_->there) return look(std::as_const(kept_->state));
    const std::lock_guard lock(kept_->there->in_use);
    const Borrowed some(*kept_, nodes, virtual_nodes);
    return look(std::as_const(kept_->state));
  }
  template <class Cut>
  int cut_with(State& state, const Cut& cut);
  template <class Get>
  bool get_from_there(const Get& get) const;
};

}  // namespace turgor::lattice
