// A state and where it is: here, or on the other side of a bus, where it steps and stays until somebody
// looks. Nobody can read what is old: whoever asks for the state gets it as it is now, and while it is
// elsewhere what changes there is empty here.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

namespace turgor {

/// What was changed here since it last went over.
enum class Changed : std::uint8_t { kNothing, kPart, kAll };

/// `There` holds one state at a time on the other side, and has get_state(state). `Room` keeps what is the
/// state's own while it is away: swap(state).
template <class StateHere, class There, class Room>
struct Mirrored {
  using State = StateHere;
  using Place = There;

  State state;
  std::shared_ptr<There> there;  // null: it steps here
  Room room;
  bool away = false, watched = false;
  Changed changed = Changed::kAll;

  void go() {
    if (!std::exchange(away, true)) room.swap(state);
  }
  /// `there` is in use by this thread.
  void download_state() {
    if (!std::exchange(away, false)) return;
    room.swap(state);
    there->get_state(state);
  }
  State& on_host() {
    if (!there) return state;
    const std::lock_guard lock(there->in_use);
    download_state();
    return state;
  }
  /// After a step: back to where views look.
  void update_views() {
    if (watched) download_state(), changed = Changed::kAll;
  }
};

/// The base of a There.
template <class Mirrored>
struct BackendOf {
  std::mutex in_use;
  std::weak_ptr<Mirrored> whose;  // state it holds
};

/// From now on `there`, which is in use by this thread, is this state's; what it held goes back.
template <class Mirrored>
void claim(const std::shared_ptr<Mirrored>& kept) {
  const std::shared_ptr<Mirrored> other = kept->there->whose.lock();
  if (other == kept) return;
  if (other) other->download_state();
  kept->changed = Changed::kAll;
  kept->there->whose = kept;
}

/// What a model's KeptState is besides its own steps.
template <class Mirrored>
class DeviceStateOf {
 public:
  using State = typename Mirrored::State;

  explicit DeviceStateOf(State state) : kept_(std::make_shared<Mirrored>()) {
    kept_->state = std::move(state);
  }
  /// A copy is here; it steps where the original does.
  DeviceStateOf(const DeviceStateOf& other) : DeviceStateOf(other.here()) {
    kept_->there = other.kept_->there;
  }
  DeviceStateOf(DeviceStateOf&&) noexcept = default;
  /// Takes the other's numbers, in the same memory, and steps where it does.
  DeviceStateOf& operator=(const DeviceStateOf& other) {
    if (this == &other) return *this;
    change() = other.here();
    kept_->there = other.kept_->there;
    return *this;
  }
  DeviceStateOf& operator=(DeviceStateOf&&) noexcept = default;
  ~DeviceStateOf() = default;

  /// As it is now. Valid until the next step.
  const State& here() const { return kept_->on_host(); }
  operator const State&() const { return here(); }
  const State& operator*() const { return here(); }
  const State* operator->() const { return &here(); }
  /// To write into, until the next step.
  State& change() {
    State& state = kept_->on_host();
    kept_->changed = Changed::kAll;
    return state;
  }
  /// For views that outlive steps: from now on every step ends with all of it here, in the same memory, and
  /// what was written there goes over before it.
  State& watch() {
    kept_->watched = true;
    return change();
  }

  /// From now on it steps there.
  void step_on(std::shared_ptr<typename Mirrored::Place> there) {
    kept_->on_host();
    kept_->there = std::move(there);
    kept_->changed = Changed::kAll;
  }

 protected:
  std::shared_ptr<Mirrored> kept_;
};

}  // namespace turgor
