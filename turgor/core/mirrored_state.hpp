// A body's state that steps on the host or on a device. Device data stay on the device from step to step and
// are downloaded only when the host reads them. Every accessor downloads first if necessary, so stale data
// cannot be read. While the state is on the device, the host arrays of these fields are empty.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

namespace turgor {

/// Host fields that were written since the last upload.
enum class Changed : std::uint8_t { kNothing, kPartial, kAll };

/// Host state with an optional device copy. `DeviceBackend` stores one state at a time and has
/// download_state(state). `HostStorage` stores the memory of the host arrays while the state is on the
/// device; swap(state) exchanges it with the state's arrays.
template <class HostState, class DeviceBackend, class HostStorage>
struct Mirrored {
  using State = HostState;
  using Backend = DeviceBackend;

  State host_state;
  std::shared_ptr<Backend> backend;  // null: the state steps on the host
  HostStorage storage;
  bool is_on_device = false, is_watched = false;
  Changed changed = Changed::kAll;
  bool lacked_memory = false;  // the state left the device since device memory ran out

  void move_to_device() {
    if (!std::exchange(is_on_device, true)) storage.swap(host_state);
  }
  /// Requires that the caller holds the backend's mutex.
  void move_to_host() {
    if (!std::exchange(is_on_device, false)) return;
    storage.swap(host_state);
    backend->download_state(host_state);
  }
  /// Later steps are on the host, since device memory ran out. Requires that the caller holds the backend's
  /// mutex and a reference to it.
  void leave_device() {
    move_to_host();
    if (backend->owner.lock().get() == this) backend->owner.reset();
    backend = nullptr, lacked_memory = true, changed = Changed::kAll;
  }
  State& on_host() {
    if (!backend) return host_state;
    const std::lock_guard lock(backend->mutex);
    move_to_host();
    return host_state;
  }
  /// After a step: downloads the state for views that outlive the step.
  void download_if_watched() {
    if (is_watched) move_to_host(), changed = Changed::kAll;
  }
};

/// Base of a device backend.
template <class Mirrored>
struct BackendOf {
  std::mutex mutex;
  std::weak_ptr<Mirrored> owner;  // state that is stored on the device
};

/// Makes this state the owner of its backend. Downloads the previous owner's state first. Requires that the
/// caller holds the backend's mutex.
template <class Mirrored>
void claim_backend(const std::shared_ptr<Mirrored>& mirrored) {
  const std::shared_ptr<Mirrored> other = mirrored->backend->owner.lock();
  if (other == mirrored) return;
  if (other) other->move_to_host();
  mirrored->changed = Changed::kAll;
  mirrored->backend->owner = mirrored;
}

/// Base of a model's DeviceState. The derived class adds the model's steps.
template <class Mirrored>
class DeviceStateOf {
 public:
  using State = typename Mirrored::State;

  explicit DeviceStateOf(State state) : mirrored_(std::make_shared<Mirrored>()) {
    mirrored_->host_state = std::move(state);
  }
  /// The copy is on the host and uses the same backend.
  DeviceStateOf(const DeviceStateOf& other) : DeviceStateOf(other.host()) {
    mirrored_->backend = other.mirrored_->backend;
  }
  DeviceStateOf(DeviceStateOf&&) noexcept = default;
  /// Copies the values into the present memory and adopts the other state's backend.
  DeviceStateOf& operator=(const DeviceStateOf& other) {
    if (this == &other) return *this;
    change() = other.host();
    mirrored_->backend = other.mirrored_->backend;
    return *this;
  }
  DeviceStateOf& operator=(DeviceStateOf&&) noexcept = default;
  ~DeviceStateOf() = default;

  /// Current state on the host, downloaded if necessary. Valid until the next step.
  const State& host() const { return mirrored_->on_host(); }
  operator const State&() const { return host(); }
  const State& operator*() const { return host(); }
  const State* operator->() const { return &host(); }
  /// Writable state on the host, valid until the next step, which uploads it.
  State& change() {
    State& state = mirrored_->on_host();
    mirrored_->changed = Changed::kAll;
    return state;
  }
  /// Writable state for views that outlive steps. From now on every step begins with an upload of written
  /// fields and ends with a download into the same memory.
  State& watch() {
    mirrored_->is_watched = true;
    return change();
  }

  /// True once after steps have moved from the device to the host, since device memory ran out.
  bool take_lack_of_memory() { return std::exchange(mirrored_->lacked_memory, false); }

  /// Later steps use this backend.
  void use_backend(std::shared_ptr<typename Mirrored::Backend> backend) {
    mirrored_->on_host();
    mirrored_->backend = std::move(backend);
    mirrored_->changed = Changed::kAll;
  }

 protected:
  std::shared_ptr<Mirrored> mirrored_;
};

}  // namespace turgor
