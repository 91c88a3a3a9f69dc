// A State and where it is: here, or on a GPU, where it steps and stays until somebody looks. Nobody can read
// what is old: whoever asks for the State gets it as it is now, and while it is elsewhere its places and
// velocities here are empty.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "turgor/models/lattice/incision.hpp"
#include "turgor/models/lattice/resample.hpp"

namespace turgor::lattice {

struct StateAndPlace;

/// A deformed CT on the other side of a bus.
struct ResampledThere {
  const std::int16_t* samples;  // there [HU]
  ResampleReport report;
};

/// A body on the other side of a bus (body_on.hpp): its model, and one state at a time.
struct BodyThere {
  virtual ~BodyThere() = default;

  virtual void put_state(const Model& model, const State& state) = 0;
  /// What a blade changes of a state: not where the nodes are and how fast.
  virtual void put_cuts(const Model& model, const State& state) = 0;
  /// Places and velocities.
  virtual void get_state(State& state) const = 0;
  /// Of the state that is there; a step whose numbers are not finite is undone. The model is the one that was
  /// put; its sweeps, damping and skin may be others since. `known`: the state that is there, without places
  /// and velocities. `smooth`: is its coarse space to be used (prepare_coarse_space)?
  virtual StepReport step(const Model& model, const State& known, bool smooth, const Inputs& inputs,
                          double dt) = 0;
  /// What resample_ct makes, left there until the next; nothing where there is no room for it. `cuts`: the
  /// state that is there, of which only what blades did to it is looked at. `ct` is the one that the body was
  /// built from.
  virtual std::optional<ResampledThere> resample(const Exec& exec, const Model& model, const State& cuts,
                                                 const CtVolume& ct, const Grid& grid,
                                                 const ResampleOptions& options) = 0;
  /// The samples of that one.
  virtual void get_resampled(std::span<std::int16_t> samples) const = 0;

  std::mutex in_use;
  std::weak_ptr<StateAndPlace> whose;  // state it holds
};

class KeptState {
 public:
  KeptState() : KeptState(State{}) {}
  KeptState(State state);
  /// A copy is here; it steps where the original does.
  KeptState(const KeptState& other);
  KeptState(KeptState&&) noexcept = default;
  /// Takes the other's numbers, in the same memory, and steps where it does.
  KeptState& operator=(const KeptState& other);
  KeptState& operator=(KeptState&&) noexcept = default;
  ~KeptState() = default;

  /// As it is now. Valid until the next step.
  const State& here() const;
  operator const State&() const { return here(); }
  const State& operator*() const { return here(); }
  const State* operator->() const { return &here(); }
  /// To write into, until the next step.
  State& change();
  /// For views that outlive steps: from now on every step ends with all of it here, in the same memory, and
  /// what was written there goes over before it.
  State& watch();
  /// cut_version, wherever it is.
  std::size_t cuts() const;

  /// From now on it steps there.
  void step_on(std::shared_ptr<BodyThere> there);
  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double dt);

  /// What the functions of these names do (incision.hpp).
  int cut_edges(const Model& model, const BladePath& path, double begin, double end, int incision);
  int cut_region(const Model& model, const BladePath& path);
  /// resample_ct, where the state is.
  ResampledCt resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                       const ResampleOptions& options = {}) const;
  /// The same where the state is elsewhere, for pictures that are drawn there: shows the samples, which last
  /// as long as that. False: it is here, or there is no room, and nothing was shown.
  bool show_resampled(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                      const ResampleOptions& options,
                      const std::function<void(const std::int16_t* there)>& show) const;

 private:
  template <class Cut>
  int cut_with(const Cut& cut);

  std::shared_ptr<StateAndPlace> kept_;
};

}  // namespace turgor::lattice
