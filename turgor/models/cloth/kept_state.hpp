// A State and where it is: here, or on a GPU, where it steps and stays until somebody looks. Nobody can read
// what is old: whoever asks for the State gets it as it is now, and while it is elsewhere its places and
// velocities here are empty. Holds and times are always here.
#pragma once

#include <memory>
#include <mutex>

#include "turgor/models/cloth/cloth.hpp"

namespace turgor::cloth {

struct StateAndPlace;

/// A sheet on the other side of a bus (sheet_on.hpp): its model, and one state at a time.
struct SheetThere {
  virtual ~SheetThere() = default;

  /// What changes, but for holds and times.
  virtual void put_state(const Model& model, const State& state) = 0;
  virtual void get_state(State& state) const = 0;
  /// Of the state that is there, with the holds and times of this one. The model is the one that was put; its
  /// sweeps, damping, friction and strain limit may be others since.
  virtual StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                          double frame) = 0;

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

  /// From now on it steps there.
  void step_on(std::shared_ptr<SheetThere> there);
  StepReport step(const Exec& exec, const Model& model, const Inputs& inputs, double frame);

  /// What the functions of these names do (cloth.hpp).
  Status hold(const Model& model, int mesh_vertex);
  Status move_hold(const Model& model, int mesh_vertex, Vec3 goal);
  Status release(const Model& model, int mesh_vertex);

 private:
  std::shared_ptr<StateAndPlace> kept_;
};

}  // namespace turgor::cloth
