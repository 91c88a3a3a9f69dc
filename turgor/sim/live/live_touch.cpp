#include "turgor/sim/live/live_touch.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "turgor/sim/live/live_ticks.hpp"

namespace turgor {

namespace {

Status check_held(const World& world, const std::vector<HeldTool>& held) {
  std::vector<bool> is_held(world.tools.size(), false);
  for (const HeldTool& one : held) {
    if (one.tool < 0 || std::size_t(one.tool) >= world.tools.size())
      return Error{fmt::format("a hand holds tool {}: expected one of the {} in the world", one.tool,
                               world.tools.size())};
    if (is_held[std::size_t(one.tool)])
      return Error{fmt::format("two hands hold the tool {}", world.tools[std::size_t(one.tool)].name)};
    is_held[std::size_t(one.tool)] = true;
  }
  return Done{};
}

}  // namespace

struct LiveTouch::Parts {
  World& world;
  LiveTicks ticks;
  std::unique_ptr<haptics::Loop> loop;
  FrameClock clock;
  int first_frame = 0;
  std::size_t most = 0;                          // ticks, and frames, that are kept
  std::vector<std::vector<FrameInputs>> frames;  // of every slot of LiveTicks::order
  bool stopped = false;

  void end_bodies();
  void rest();
  HapticTool felt_tool(std::size_t slot) const;
};

LiveTouch::LiveTouch(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

LiveTouch::~LiveTouch() { stop(); }

Result<std::unique_ptr<LiveTouch>> LiveTouch::start(World& world, const std::vector<HeldTool>& held,
                                                    const LiveParams& params) {
  if (Status status = check_held(world, held); !status) return status.error();
  std::unique_ptr<Parts> parts(new Parts{world, {}, {}, FrameClock(world.dt), world.frame, 0, {}});
  LiveTicks& ticks = parts->ticks;
  ticks.period = ticks.step = 1 / params.loop.rate;
  const auto most = std::min(kMostTicks, std::size_t(std::ceil(params.longest / ticks.period)) + 1);
  parts->most = most;
  prepare_ticks(world, held, most, ticks);
  parts->frames.resize(ticks.order.size());
  std::vector<haptics::Hand> hands;
  for (const HeldTool& one : held) hands.push_back(one.hand);
  Result<std::unique_ptr<haptics::Loop>> loop = haptics::Loop::start(hands, tick_all, &ticks, params.loop);
  if (!loop) {
    parts->end_bodies();
    return loop.error();
  }
  parts->loop = std::move(*loop);
  return std::unique_ptr<LiveTouch>(new LiveTouch(std::move(parts)));
}

void LiveTouch::note_frame() {
  Parts& p = *parts_;
  for (const TickedBody& ticked : p.ticks.bodies)
    visit_body(p.world, ticked.id, [&](const auto& body) {
      if constexpr (is_touched<decltype(body)>)
        for (std::size_t t = 0; t < ticked.count; t++)
          if (p.frames[ticked.first + t].size() < p.most)
            p.frames[ticked.first + t].push_back(frame_inputs(body, t));
    });
}

double LiveTouch::wait_for_frame() { return parts_->clock.wait(parts_->world.frame); }

void LiveTouch::set_pace(double pace) {
  LiveTicks& ticks = parts_->ticks;
  ticks.left = pace > 0 ? -1 : 0;
  if (!(pace > 0)) return;
  ticks.pace = pace;
  parts_->clock.set_pace(pace);
}

void LiveTouch::allow(double time) {
  LiveTicks& ticks = parts_->ticks;
  if (ticks.left >= 0) ticks.left += std::lround(time / (ticks.period * ticks.pace));
}

const std::vector<HapticStatus>& LiveTouch::haptic() { return parts_->ticks.haptic.read(); }

void LiveTouch::Parts::end_bodies() {
  for_each_touched(world, [](BodyId, auto& body) { end_haptics(body); });
}

void LiveTouch::stop() {
  Parts& p = *parts_;
  if (p.stopped) return;
  p.stopped = true;
  p.loop->stop();
  p.end_bodies();
  p.world.tools = std::move(p.ticks.tools);  // with the ways of their own that frames had in place of hands
}

/// Until the haptic thread has seen that it is to rest: a tick that was on its way then is over.
void LiveTouch::Parts::rest() {
  ticks.rests = true;
  const long seen = ticks.turns;
  while (ticks.turns < seen + 2 && loop->running())
    std::this_thread::sleep_for(std::chrono::microseconds(200));
}

/// World::tools are the haptic thread's.
HapticTool LiveTouch::Parts::felt_tool(std::size_t slot) const {
  const TickedTool& ticked = ticks.order[slot];
  const TouchingTool& tool = world.tools[std::size_t(ticked.index)];
  HapticTool haptic{.name = tool.name, .ticks = {}, .frames = frames[slot]};
  for (std::size_t n = 0; n < ticked.rows.size(); n++)
    haptic.ticks.push_back({.time = tool.samples[n].time,
                            .step = ticked.rows[n].step,
                            .command = command_of(tool.samples[n]),
                            .inputs_used = ticked.rows[n].inputs_used});
  return haptic;
}

Result<HapticRecording> LiveTouch::haptic_recording() {
  Parts& p = *parts_;
  if (p.first_frame > 0) return Error{"no felt run: the world was not felt from its beginning"};
  if (!p.stopped) {
    p.rest();
    std::swap(p.world.tools, p.ticks.tools);
  }
  HapticRecording run{.frames = p.world.frame, .hash = state_hash(p.world)};
  run.tools.resize(p.world.tools.size());
  bool is_whole = true;
  for (std::size_t slot = 0; slot < p.ticks.order.size(); slot++) {
    const auto tool = std::size_t(p.ticks.order[slot].index);
    run.tools[tool] = p.felt_tool(slot);
    is_whole = is_whole && p.world.tools[tool].samples.missed() == 0 &&
               run.tools[tool].frames.size() == std::size_t(run.frames);
  }
  if (!p.stopped) {
    std::swap(p.world.tools, p.ticks.tools);
    p.ticks.rests = false;
  }
  if (!is_whole) return Error{"no felt run: it is longer than what is kept of it"};
  return run;
}

const haptics::TimingReport& LiveTouch::timing() { return parts_->loop->report(); }

FrameTiming LiveTouch::frames() const { return parts_->clock.timing(); }

std::vector<std::string> LiveTouch::notes() const { return parts_->loop->notes(); }

}  // namespace turgor
