#include "turgor/sim/live/live_touch.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/live/live_ticks.hpp"

namespace turgor {

namespace {

Status check_held(const World& world, const std::vector<HeldTool>& held) {
  std::vector<bool> is_held(world.tools.size(), false);
  for (const HeldTool& one : held) {
    if (one.tool < 0 || std::size_t(one.tool) >= world.tools.size())
      return Error{fmt::format("a device holds tool {}: expected one of the {} in the world", one.tool,
                               world.tools.size())};
    if (is_held[std::size_t(one.tool)])
      return Error{fmt::format("two devices hold the tool {}", world.tools[std::size_t(one.tool)].name)};
    is_held[std::size_t(one.tool)] = true;
  }
  return Done{};
}

}  // namespace

struct LiveTouch::Impl {
  World& world;
  LiveTicks ticks;
  std::unique_ptr<haptics::Loop> loop;
  FrameClock clock;
  int first_frame = 0;
  std::size_t most = 0;                          // largest number of recorded ticks, and of frames
  std::vector<std::vector<FrameInputs>> frames;  // inputs of every frame, for each entry of LiveTicks::order
  bool stopped = false;
  std::optional<HapticLogWriter> log;

  void end_bodies();
  void log_frame();
  void pause_ticks();
  HapticTool recorded_tool(std::size_t slot) const;
};

LiveTouch::LiveTouch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LiveTouch::~LiveTouch() { stop(); }

Result<std::unique_ptr<LiveTouch>> LiveTouch::start(World& world, const std::vector<HeldTool>& held,
                                                    const LiveParams& params) {
  if (Status status = check_held(world, held); !status) return status.error();

  // ticks
  std::unique_ptr<Impl> impl(new Impl{world, {}, {}, FrameClock(world.dt), world.frame, 0, {}});
  std::vector<haptics::Hand> hands;
  for (const HeldTool& one : held) hands.push_back(one.hand);
  LiveTicks& ticks = impl->ticks;
  ticks.period = ticks.step = 1 / haptics::loop_rate(hands, params.loop.rate);
  const auto most = std::min(kMostTicks, std::size_t(std::ceil(params.longest / ticks.period)) + 1);
  impl->most = most;
  prepare_ticks(world, held, {most, params.in_memory}, ticks);
  impl->frames.resize(ticks.order.size());

  // haptic loop
  Result<std::unique_ptr<haptics::Loop>> loop = haptics::Loop::start(hands, tick_all, &ticks, params.loop);
  if (!loop) {
    impl->end_bodies();
    return loop.error();
  }
  impl->loop = std::move(*loop);
  return std::unique_ptr<LiveTouch>(new LiveTouch(std::move(impl)));
}

void LiveTouch::begin_log(const std::filesystem::path& goal, const Scene& scene) {
  Impl& p = *impl_;
  HapticRecording run;
  set_scene(scene, false, run);
  std::vector<int> ticked;
  for (const TouchingTool& tool : p.world.tools)
    run.tools.push_back({.name = tool.name, .ticks = {}, .frames = {}});
  for (const TickedTool& tool : p.ticks.order) ticked.push_back(tool.index);
  p.log.emplace(goal, run, ticked);
}

HapticLogWriter* LiveTouch::log() { return impl_->log ? &*impl_->log : nullptr; }

/// Adds the latest frame to the log.
void LiveTouch::Impl::log_frame() {
  std::vector<LoggedTool> tools;
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    tools.push_back({&ticks.order[slot].recorded, frames[slot].back()});
  log->add_frame(tools);
}

void LiveTouch::record_frame_inputs() {
  Impl& p = *impl_;
  TURGOR_CHECK(p.frames.size() == p.ticks.order.size(), "every ticked tool has a list of frames");
  for (const TickedBody& ticked : p.ticks.bodies)
    visit_body(p.world, ticked.id, [&](const auto& body) {
      if constexpr (is_touched<decltype(body)>)
        for (std::size_t t = 0; t < ticked.count; t++)
          if (p.frames[ticked.first + t].size() < p.most)
            p.frames[ticked.first + t].push_back(frame_inputs(body, t));
    });
  if (p.log && p.first_frame == 0) p.log_frame();
  save_ticks(p.ticks);
}

double LiveTouch::wait_for_frame() { return impl_->clock.wait(impl_->world.frame); }

void LiveTouch::set_pace(double pace) {
  LiveTicks& ticks = impl_->ticks;
  ticks.allowed = pace > 0 ? -1 : 0;
  if (!(pace > 0)) return;
  ticks.pace = pace;
  impl_->clock.set_pace(pace);
}

void LiveTouch::allow(double time) {
  LiveTicks& ticks = impl_->ticks;
  TURGOR_CHECK(ticks.pace > 0 && ticks.period > 0, "a clock that stands still remembers its pace");
  if (ticks.allowed >= 0) ticks.allowed += std::lround(time / (ticks.period * ticks.pace));
}

const std::vector<HapticStatus>& LiveTouch::haptic() { return impl_->ticks.haptic.read(); }

void LiveTouch::Impl::end_bodies() {
  for_each_touched(world, [](BodyId, auto& body) { end_haptics(body); });
}

void LiveTouch::stop() {
  Impl& p = *impl_;
  if (p.stopped) return;
  p.stopped = true;
  p.loop->stop();
  p.end_bodies();
  p.world.tools = std::move(p.ticks.tools);  // the world's own tools have the poses of frames only
}

/// Pauses the haptic thread; returns after a tick in progress has ended.
void LiveTouch::Impl::pause_ticks() {
  ticks.is_paused = true;
  const long seen = ticks.loop_count;
  while (ticks.loop_count < seen + 2 && loop->running())
    std::this_thread::sleep_for(std::chrono::microseconds(200));
}

/// Recording of one tool. World::tools must be those of the haptic thread.
HapticTool LiveTouch::Impl::recorded_tool(std::size_t slot) const {
  TURGOR_CHECK(is_index(slot, ticks.order.size()), "a recorded tool was ticked");
  const TickedTool& ticked = ticks.order[slot];
  const TouchingTool& tool = world.tools[std::size_t(ticked.index)];
  TURGOR_CHECK(ticked.recorded.size() <= tool.samples.size(), "every recorded tick has a sample");
  return {.name = tool.name, .ticks = ticked.recorded, .frames = frames[slot]};
}

Result<HapticRecording> LiveTouch::haptic_recording() {
  Impl& p = *impl_;
  if (p.first_frame > 0) return Error{"no haptic recording: haptics did not start at the first frame"};

  // pause the ticks and borrow their tools
  if (!p.stopped) {
    p.pause_ticks();
    std::swap(p.world.tools, p.ticks.tools);
  }

  // record of every tool
  HapticRecording run{.frames = p.world.frame, .hash = state_hash(p.world)};
  run.tools.resize(p.world.tools.size());
  bool is_whole = true;
  for (std::size_t slot = 0; slot < p.ticks.order.size(); slot++) {
    const auto tool = std::size_t(p.ticks.order[slot].index);
    TURGOR_CHECK(is_index(tool, run.tools.size()), "a ticked tool is a tool of the world");
    run.tools[tool] = p.recorded_tool(slot);
    is_whole = is_whole && p.ticks.order[slot].recorded.missed() == 0 &&
               run.tools[tool].frames.size() == std::size_t(run.frames);
  }

  // resume
  if (!p.stopped) {
    std::swap(p.world.tools, p.ticks.tools);
    p.ticks.is_paused = false;
  }
  if (!is_whole) return Error{"no haptic recording: the run is longer than the record"};
  return run;
}

const haptics::TimingReport& LiveTouch::timing() { return impl_->loop->report(); }

FrameTiming LiveTouch::frames() const { return impl_->clock.timing(); }

std::vector<std::string> LiveTouch::news() { return impl_->loop->news(); }

std::vector<std::string> LiveTouch::notes() const {
  std::vector<std::string> notes = impl_->loop->notes();
  notes.insert(notes.end(), impl_->ticks.notes.begin(), impl_->ticks.notes.end());
  return notes;
}

}  // namespace turgor
