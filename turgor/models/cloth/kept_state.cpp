#include "turgor/models/cloth/kept_state.hpp"

#include <utility>

namespace turgor::cloth {

struct StateAndPlace {
  State state;
  std::shared_ptr<SheetThere> there;  // null: it steps here
  Vectors x, v, last_x, last_v;       // room of the state's own, while it is away
  bool away = false, watched = false;
  bool changed = true;  // here, since it last went over

  void swap_room() {
    std::swap(x, state.x), std::swap(v, state.v);
    std::swap(last_x, state.last.x), std::swap(last_v, state.last.v);
  }
  void go() {
    if (!std::exchange(away, true)) swap_room();
  }
  /// `there` is in use by this thread.
  void come_back() {
    if (!std::exchange(away, false)) return;
    swap_room();
    there->get_state(state);
  }
  State& at_home() {
    if (!there) return state;
    const std::lock_guard lock(there->in_use);
    come_back();
    return state;
  }
};

namespace {

/// What is there is this state, as it is.
void put_over(const Model& model, const std::shared_ptr<StateAndPlace>& kept) {
  SheetThere& there = *kept->there;
  const std::shared_ptr<StateAndPlace> other = there.whose.lock();
  if (other != kept) {
    if (other) other->come_back();
    kept->changed = true;
    there.whose = kept;
  }
  if (std::exchange(kept->changed, false)) there.put_state(model, kept->state);
}

}  // namespace

KeptState::KeptState(State state) : kept_(std::make_shared<StateAndPlace>()) {
  kept_->state = std::move(state);
}

KeptState::KeptState(const KeptState& other) : KeptState(other.here()) { kept_->there = other.kept_->there; }

KeptState& KeptState::operator=(const KeptState& other) {
  if (this == &other) return *this;
  change() = other.here();
  kept_->there = other.kept_->there;
  return *this;
}

const State& KeptState::here() const { return kept_->at_home(); }

State& KeptState::change() {
  State& state = kept_->at_home();
  kept_->changed = true;
  return state;
}

State& KeptState::watch() {
  kept_->watched = true;
  return change();
}

void KeptState::step_on(std::shared_ptr<SheetThere> there) {
  kept_->at_home();
  kept_->there = std::move(there);
  kept_->changed = true;
}

StepReport KeptState::step(const Exec& exec, const Model& model, const Inputs& inputs, double frame) {
  if (!kept_->there) return cloth::step(exec, model, kept_->state, inputs, frame);
  const std::lock_guard lock(kept_->there->in_use);
  put_over(model, kept_);
  kept_->go();
  const StepReport report = kept_->there->step(exec, model, kept_->state, inputs, frame);
  if (kept_->watched) kept_->come_back(), kept_->changed = true;
  return report;
}

Status KeptState::hold(const Model& model, int mesh_vertex) {
  return cloth::hold(model, kept_->at_home(), mesh_vertex);
}
Status KeptState::move_hold(const Model& model, int mesh_vertex, Vec3 goal) {
  return cloth::move_hold(model, kept_->state, mesh_vertex, goal);
}
Status KeptState::release(const Model& model, int mesh_vertex) {
  return cloth::release(model, kept_->state, mesh_vertex);
}

}  // namespace turgor::cloth
