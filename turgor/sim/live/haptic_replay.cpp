#include "turgor/sim/live/haptic_replay.hpp"

#include <fmt/format.h>

namespace turgor {

namespace {

/// A body with tools, and how far its ticks are.
struct ReplayedBody {
  BodyId id;
  std::vector<const HapticTool*> tools;  // one for each of its tool_indices
  std::size_t done = 0;                  // ticks
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
};

/// The next tick of a body.
template <class Body>
void tick_next(ReplayedBody& replayed, Body& body, std::vector<TouchingTool>& tools) {
  const std::size_t tick = replayed.done++;
  const double step = replayed.tools[0]->ticks[tick].step;
  for (std::size_t t = 0; t < replayed.tools.size(); t++) {
    const HapticTick& haptic = replayed.tools[t]->ticks[tick];
    give_frame(body, t, haptic.inputs_used);
    replayed.commands[t] = haptic.command;
    replayed.readings[t] = {};
  }
  tick_haptics(body, replayed.commands, step, replayed.readings);
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
    return Error{fmt::format("the felt run has {} tools: expected the {} of its scene", run.tools.size(),
                             world.tools.size())};
  for (std::size_t t = 0; t < run.tools.size(); t++)
    if (run.tools[t].name != world.tools[t].name)
      return Error{fmt::format("the felt run has a tool {}: expected {} of its scene", run.tools[t].name,
                               world.tools[t].name)};
  return Done{};
}

/// Tools of one body tick together.
Status check_ticks(const World& world, const HapticRecording& run) {
  Status status = Done{};
  for_each_touched(world, [&](BodyId, const auto& body) {
    for (const int t : body.tool_indices) {
      const HapticTool &first = run.tools[std::size_t(body.tool_indices[0])],
                       &tool = run.tools[std::size_t(t)];
      if (tool.ticks.size() != first.ticks.size() || tool.frames.size() != first.frames.size())
        status = Error{fmt::format("the felt run is damaged: {} and {} tick apart", first.name, tool.name)};
    }
  });
  return status;
}

}  // namespace

struct HapticReplay::Parts {
  World& world;
  HapticRecording run;
  std::shared_ptr<const Scene> scene;
  std::vector<TouchingTool> tools;  // as World::tools, with what is felt; the world's own go with the frames
  std::vector<ReplayedBody> bodies;
  std::size_t asked = 0;
  int built_patches = 0;
  bool ended = false;

  void begin();
  template <class Body>
  void tick_until(ReplayedBody& replayed, Body& body, std::size_t tick);
  void tick_before_frame();
  Status grant_asks(const Exec& exec);
};

void HapticReplay::Parts::begin() {
  tools = world.tools;
  for_each_touched(world, [this](BodyId id, auto& body) {
    if (body.tool_indices.empty()) return;
    begin_haptics(body, world.tools);
    ReplayedBody& replayed = bodies.emplace_back();
    replayed.id = id;
    for (const int tool : body.tool_indices) replayed.tools.push_back(&run.tools[std::size_t(tool)]);
    replayed.commands.resize(replayed.tools.size());
    replayed.readings.resize(replayed.tools.size());
  });
}

template <class Body>
void HapticReplay::Parts::tick_until(ReplayedBody& replayed, Body& body, std::size_t tick) {
  const std::size_t last = std::min(tick, replayed.tools[0]->ticks.size());
  while (replayed.done < last) tick_next(replayed, body, tools);
}

/// Of every body what the next frame knew of it.
void HapticReplay::Parts::tick_before_frame() {
  const auto frame = std::size_t(world.frame);
  for (ReplayedBody& replayed : bodies)
    visit_body(world, replayed.id, [&](auto& body) {
      if constexpr (is_touched<decltype(body)>) {
        if (frame > 0) keep_frame(body);
        const std::vector<FrameInputs>& inputs_used = replayed.tools[0]->frames;
        if (frame >= inputs_used.size()) return;
        expect_patch(body, inputs_used[frame].patches > (frame > 0 ? inputs_used[frame - 1].patches : 0));
        tick_until(replayed, body, std::size_t(inputs_used[frame].ticks));
      }
    });
}

Status HapticReplay::Parts::grant_asks(const Exec& exec) {
  Status status = Done{};
  for (; asked < run.requests.size() && run.requests[asked].frame <= world.frame && status; asked++)
    status = std::visit([&](const auto& request) { return apply_request(exec, request, scene, world); },
                        run.requests[asked].what);
  return status;
}

HapticReplay::HapticReplay(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

HapticReplay::~HapticReplay() { end(); }

Result<std::unique_ptr<HapticReplay>> HapticReplay::begin(World& world, HapticRecording run) {
  Status status = check_tools(world, run);
  if (status) status = check_ticks(world, run);
  if (!status) return status.error();
  Result<Scene> scene = scene_of(run);
  if (!scene) return scene.error();
  std::unique_ptr<Parts> parts(
      new Parts{world, std::move(run), std::make_shared<const Scene>(std::move(*scene)), {}, {}});
  parts->begin();
  return std::unique_ptr<HapticReplay>(new HapticReplay(std::move(parts)));
}

Status HapticReplay::next_frame(const Exec& exec) {
  if (const Status status = parts_->grant_asks(exec); !status) return status;
  parts_->tick_before_frame();
  return Done{};
}

void HapticReplay::end() {
  Parts& p = *parts_;
  if (p.ended) return;
  p.ended = true;
  for (ReplayedBody& replayed : p.bodies)
    visit_body(p.world, replayed.id, [&](auto& body) {
      if constexpr (is_touched<decltype(body)>) {
        if (p.world.frame > 0) keep_frame(body);
        p.tick_until(replayed, body, replayed.tools[0]->ticks.size());
      }
    });
  for_each_touched(p.world, [](BodyId, auto& body) { end_haptics(body); });
  p.world.tools = std::move(p.tools);
}

const HapticRecording& HapticReplay::run() const { return parts_->run; }

}  // namespace turgor
