// State of a tg_world, and the checks common to all calls.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "c/guard.hpp"
#include "turgor/sim/autosave/saved_world.hpp"
#include "turgor/sim/live/driven_ticks.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

struct tg_world {
  explicit tg_world(int threads) : exec(threads) {}

  turgor::Exec exec;
  std::shared_ptr<const turgor::Scene> scene;
  std::unique_ptr<turgor::World> world;
  turgor::Measures measures;                  // of the frames of tg_world_step
  turgor::LoadedWorld loaded;                 // for saved states
  std::optional<turgor::DrivenTicks> driven;  // used by tg_world_tick and tg_touch_tick
  bool touched = false;                       // between tg_touch_begin and tg_touch_end
  bool was_touched = false;
  turgor::WorldSnapshot snapshot;
  bool is_shown = false;
  std::uint64_t replaced_cuts = 0;                     // states read that had other cuts
  std::vector<turgor::contact::ToolCommand> commands;  // one per tool, as `readings`
  std::vector<turgor::contact::ToolReading> readings;
  std::deque<std::string> names;  // of cuts and stitches by hand that were returned to the caller
  std::atomic<bool> is_busy{false}, is_ticked{false};  // a call, or a haptic tick, is in progress
  std::atomic<bool> is_broken{false};
};

namespace turgor::c {

/// Guard that admits one caller at a time.
class Entered {
 public:
  explicit Entered(std::atomic<bool>& busy) : busy_(busy) {
    if (busy.exchange(true))
      throw Misuse("expected one thread at a time, found this world in a call of another thread");
  }
  ~Entered() { busy_ = false; }
  Entered(const Entered&) = delete;
  Entered& operator=(const Entered&) = delete;

 private:
  std::atomic<bool>& busy_;
};

/// Runs `call` with a valid world; TG_BROKEN marks the world as broken.
template <class Call>
tg_status with(tg_world* world, std::atomic<bool> tg_world::*busy, const Call& call) noexcept {
  const tg_status status = guarded([&] {
    expect(world != nullptr, "expected a world, found null");
    if (world->is_broken) throw Broken("this world broke in an earlier call; it can only be destroyed");
    const Entered entered(world->*busy);
    call(*world);
  });
  if (status == TG_BROKEN && world) world->is_broken = true;
  return status;
}
template <class Call>
tg_status with(tg_world* world, const Call& call) noexcept {
  return with(world, &tg_world::is_busy, call);
}

/// Misuse: tg_touch_end has ended the haptic session of the world.
void expect_unended(const tg_world& world);

/// Body of that index. Misuse: an index out of range.
BodyId id_of(const tg_world& world, std::int32_t index);

}  // namespace turgor::c
