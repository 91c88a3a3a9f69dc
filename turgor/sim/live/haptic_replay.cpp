#include "turgor/sim/live/haptic_replay.hpp"

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// A touched body and the progress of its ticks.
struct ReplayedBody {
  BodyId id;
  std::vector<const HapticTool*> tools;  // one for each of tool_indices
  std::size_t done = 0;                  // number of ticks done
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
};

/// Runs the next tick of a body.
template <class Body>
void tick_next(ReplayedBody& replayed, Body& body, std::vector<TouchingTool>& tools) {
  // recorded commands and inputs
  TURGOR_ASSERT(!replayed.tools.empty(), "a replayed body has a tool");
  const std::size_t tick = replayed.done++;
  TURGOR_CHECK(tick < replayed.tools[0]->ticks.size(), "the replayed tick was recorded");
  const double step = replayed.tools[0]->ticks[tick].step;
  for (std::size_t t = 0; t < replayed.tools.size(); t++) {
    const HapticTick& haptic = replayed.tools[t]->ticks[tick];
    replay_frame_output(body, t, haptic.inputs_used);
    replayed.commands[t] = haptic.command;
    replayed.readings[t] = {};
  }

  // tick
  tick_haptics(body, replayed.commands, step, replayed.readings);
  // log
  for (std::size_t t = 0; t < replayed.tools.size(); t++) {
    TouchingTool& tool = tools[std::size_t(body.tool_indices[t])];
    tool.grip = replayed.commands[t].grip;
    log_tick(body, t,
             sample_of(replayed.tools[t]->ticks[tick].time, replayed.commands[t], replayed.readings[t]),
             tool);
  }
}

Status check_tools(const World& world, const HapticRecording& run) {
  if (run.tools.size() != world.tools.size())
    return Error{fmt::format("the haptic recording has {} tools: expected the {} of its scene",
                             run.tools.size(), world.tools.size())};
  for (std::size_t t = 0; t < run.tools.size(); t++)
    if (run.tools[t].name != world.tools[t].name)
      return Error{fmt::format("the haptic recording has a tool {}: expected {} of its scene",
                               run.tools[t].name, world.tools[t].name)};
  return Done{};
}

/// Checks that the tools of a body have the same number of ticks and frames.
Status check_ticks(const World& world, const HapticRecording& run) {
  Status status = Done{};
  for_each_touched(world, [&](BodyId, const auto& body) {
    for (const int t : body.tool_indices) {
      const HapticTool &first = run.tools[std::size_t(body.tool_indices[0])],
                       &tool = run.tools[std::size_t(t)];
      if (tool.ticks.size() != first.ticks.size() || tool.frames.size() != first.frames.size())
        status = Error{fmt::format("the haptic recording is damaged: {} and {} have different ticks",
                                   first.name, tool.name)};
    }
  });
  return status;
}

}  // namespace

struct HapticReplay::Impl {
  World& world;
  HapticRecording run;
  std::shared_ptr<const Scene> scene;
  std::vector<TouchingTool>
      tools;  // copy of World::tools with the logs of ticks; frames move the world's own tools
  std::vector<ReplayedBody> bodies;
  std::size_t next_request = 0;
  int built_patches = 0;
  bool ended = false;

  void begin();
  template <class Body>
  void tick_until(ReplayedBody& replayed, Body& body, std::size_t tick);
  void tick_before_frame();
  Status apply_requests(const Exec& exec);
};

void HapticReplay::Impl::begin() {
  tools = world.tools;
  for_each_touched(world, [this](BodyId id, auto& body) {
    if (body.tool_indices.empty()) return;
    begin_haptics(body, world.tools);
    ReplayedBody& replayed = bodies.emplace_back();
    replayed.id = id;
    for (const int tool : body.tool_indices) replayed.tools.push_back(&run.tools[std::size_t(tool)]);
    const DiskLog<HapticTick>& ticks = replayed.tools[0]->ticks;
    if (ticks.size() > 0 && ticks[0].inputs_used.solution >= 0) (void)begin_solutions(body, true);
    replayed.commands.resize(replayed.tools.size());
    replayed.readings.resize(replayed.tools.size());
  });
}

template <class Body>
void HapticReplay::Impl::tick_until(ReplayedBody& replayed, Body& body, std::size_t tick) {
  const std::size_t last = std::min(tick, replayed.tools[0]->ticks.size());
  while (replayed.done < last) tick_next(replayed, body, tools);
}

/// Runs, for every body, the ticks that the next frame used.
void HapticReplay::Impl::tick_before_frame() {
  const auto frame = std::size_t(world.frame);
  for (ReplayedBody& replayed : bodies)
    visit_body(world, replayed.id, [&](auto& body) {
      if constexpr (is_touched<decltype(body)>) {
        if (frame > 0) queue_frame_output(body);
        const std::vector<FrameInputs>& inputs_used = replayed.tools[0]->frames;
        if (frame >= inputs_used.size()) return;
        expect_patch(body, inputs_used[frame].patches > (frame > 0 ? inputs_used[frame - 1].patches : 0));
        tick_until(replayed, body, std::size_t(inputs_used[frame].ticks));
      }
    });
}

Status HapticReplay::Impl::apply_requests(const Exec& exec) {
  Status status = Done{};
  for (; next_request < run.requests.size() && run.requests[next_request].frame <= world.frame && status;
       next_request++)
    status = std::visit([&](const auto& request) { return apply_request(exec, request, scene, world); },
                        run.requests[next_request].what);
  return status;
}

HapticReplay::HapticReplay(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HapticReplay::~HapticReplay() { end(); }

Result<std::unique_ptr<HapticReplay>> HapticReplay::begin(World& world, HapticRecording run) {
  Status status = check_tools(world, run);
  if (status) status = check_ticks(world, run);
  if (!status) return status.error();
  Result<Scene> scene = scene_of(run);
  if (!scene) return scene.error();
  std::unique_ptr<Impl> impl(
      new Impl{world, std::move(run), std::make_shared<const Scene>(std::move(*scene)), {}, {}});
  impl->begin();
  return std::unique_ptr<HapticReplay>(new HapticReplay(std::move(impl)));
}

Status HapticReplay::next_frame(const Exec& exec) {
  if (const Status status = impl_->apply_requests(exec); !status) return status;
  impl_->tick_before_frame();
  return Done{};
}

void HapticReplay::end() {
  Impl& p = *impl_;
  if (p.ended) return;
  p.ended = true;
  for (ReplayedBody& replayed : p.bodies)
    visit_body(p.world, replayed.id, [&](auto& body) {
      if constexpr (is_touched<decltype(body)>) {
        if (p.world.frame > 0) queue_frame_output(body);
        p.tick_until(replayed, body, replayed.tools[0]->ticks.size());
      }
    });
  for_each_touched(p.world, [](BodyId, auto& body) { end_haptics(body); });
  p.world.tools = std::move(p.tools);
}

const HapticRecording& HapticReplay::run() const { return impl_->run; }

}  // namespace turgor
