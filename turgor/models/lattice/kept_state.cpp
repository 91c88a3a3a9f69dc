#include "turgor/models/lattice/kept_state.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/coarse.hpp"

namespace turgor::lattice {

/// What was changed here since it last went over.
enum class Changed : std::uint8_t { kNothing, kCuts, kAll };

struct StateAndPlace {
  State state;
  std::shared_ptr<BodyThere> there;  // null: it steps here
  VecField u, u_before, v;           // room of the state's own, while it is away
  bool away = false, watched = false;
  Changed changed = Changed::kAll;

  void swap_room() { std::swap(u, state.u), std::swap(u_before, state.u_before), std::swap(v, state.v); }
  void go() {
    if (std::exchange(away, true)) return;
    swap_room();
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
  BodyThere& there = *kept->there;
  const std::shared_ptr<StateAndPlace> other = there.whose.lock();
  if (other != kept) {
    if (other) other->come_back();
    kept->changed = Changed::kAll;
    there.whose = kept;
  }
  if (kept->changed == Changed::kAll) there.put_state(model, kept->state);
  if (kept->changed == Changed::kCuts) there.put_cuts(model, kept->state);
  kept->changed = Changed::kNothing;
}

/// Are the state's numbers there as well, whether or not they came back?
bool is_there(const std::shared_ptr<StateAndPlace>& kept) {
  return kept->there->whose.lock() == kept && kept->changed == Changed::kNothing;
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
  kept_->changed = Changed::kAll;
  return state;
}

State& KeptState::watch() {
  kept_->watched = true;
  return change();
}

std::size_t KeptState::cuts() const { return cut_version(kept_->state); }

void KeptState::step_on(std::shared_ptr<BodyThere> there) {
  kept_->at_home();
  kept_->there = std::move(there);
  kept_->changed = Changed::kAll;
}

StepReport KeptState::step(const Exec& exec, const Model& model, const Inputs& inputs, double dt) {
  if (!kept_->there) return lattice::step(exec, model, kept_->state, inputs, dt);
  const std::lock_guard lock(kept_->there->in_use);
  put_over(model, kept_);
  kept_->go();
  State& state = kept_->state;
  const bool smooth = prepare_coarse_space(model, state, inputs, dt);
  const StepReport report = kept_->there->step(model, state, smooth, inputs, dt);
  state.fastest = report.largest_speed;
  if (report.finite) state.time += dt;
  if (kept_->watched) kept_->come_back(), kept_->changed = Changed::kAll;
  return report;
}

ResampledCt KeptState::resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                                const ResampleOptions& options) const {
  if (kept_->there) {
    const Timer timer;
    const std::lock_guard lock(kept_->there->in_use);
    if (is_there(kept_))
      if (const auto made = kept_->there->resample(exec, model, kept_->state, ct, grid, options)) {
        ResampledCt now{.ct = {.grid = grid, .samples = {}}, .report = made->report};
        now.ct.samples.resize(sample_count(grid));
        kept_->there->get_resampled(now.ct.samples);
        now.report.seconds = timer.seconds();
        return now;
      }
  }
  return resample_ct(exec, model, here(), ct, grid, options);
}

bool KeptState::show_resampled(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                               const ResampleOptions& options,
                               const std::function<void(const std::int16_t*)>& show) const {
  if (!kept_->there) return false;
  const std::lock_guard lock(kept_->there->in_use);
  if (!is_there(kept_)) return false;
  const auto made = kept_->there->resample(exec, model, kept_->state, ct, grid, options);
  if (made) show(made->samples);
  return made.has_value();
}

template <class Cut>
int KeptState::cut_with(const Cut& cut) {
  State& state = kept_->at_home();
  const std::size_t before = cut_version(state);
  const int count = cut(state);
  if (count > 0 || cut_version(state) != before) kept_->changed = std::max(kept_->changed, Changed::kCuts);
  return count;
}

int KeptState::cut_edges(const Model& model, const BladePath& path, double begin, double end, int incision) {
  return cut_with([&](State& state) { return lattice::cut_edges(model, state, path, begin, end, incision); });
}

int KeptState::cut_region(const Model& model, const BladePath& path) {
  return cut_with([&](State& state) { return lattice::cut_region(model, state, path); });
}

}  // namespace turgor::lattice
