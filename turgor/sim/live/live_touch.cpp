#include "turgor/sim/live/live_touch.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turgor/haptics/real_time.hpp"
#include "turgor/sim/live/exchanges.hpp"

namespace turgor {

namespace {

/// A body and its part of the commands.
struct TickedBody {
  BodyId id;
  std::size_t first = 0, count = 0;  // of LiveTicks::tools
};

/// A tool as the haptic thread has it.
struct TickedTool {
  int index = 0;  // into World::tools
  int hand = -1;  // of the devices; -1: it goes on its path
  bool has_grip = false;
  contact::LocalTouch local;  // on bodies that are felt by the frame
  double plane_time = 0;      // when the newest plane came [s]
};

/// What the haptic thread owns, besides the touches of the bodies.
struct LiveTicks {
  World* world = nullptr;
  Exchanges* exchanges = nullptr;
  double period = kTick;            // [s]
  long done = 0;                    // ticks
  std::vector<TouchingTool> tools;  // as World::tools, whose paths, logs and grips it goes on with
  std::vector<TickedBody> bodies;
  std::vector<TickedTool> order;  // body by body, as the two below
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;

  double time() const { return double(done) * period; }
};

/// The hand's, with jaws that close while the button is held where the device has none.
contact::ToolCommand command_of(const LiveTicks& ticks, const TickedTool& ticked, TouchingTool& tool,
                                std::span<const contact::ToolCommand> hands) {
  if (ticked.hand < 0) return next_command(tool, ticks.time());
  contact::ToolCommand command = hands[std::size_t(ticked.hand)];
  if (!ticked.has_grip)
    command.grip = contact::next_grip(tool.grip, command.hold, holding_time(tool), ticks.period);
  tool.grip = command.grip;
  return command;
}

/// A tool on a body that is felt by the frame.
void tick_local(LiveTicks& ticks, std::size_t slot) {
  TickedTool& ticked = ticks.order[slot];
  LocalExchange& exchange = *ticks.exchanges->local[std::size_t(ticked.index)];
  exchange.command.write(ticks.commands[slot]);
  if (exchange.plane.has_news()) {
    contact::take(ticked.local, exchange.plane.read());
    ticked.plane_time = ticks.time();
  }
  contact::tick(ticked.local, ticks.commands[slot], ticks.period, ticks.readings[slot]);
  ticks.readings[slot].age = ticks.time() - ticked.plane_time;
}

void tick_body(LiveTicks& ticks, const TickedBody& body) {
  const std::span<const contact::ToolCommand> commands(&ticks.commands[body.first], body.count);
  const std::span<contact::ToolReading> readings(&ticks.readings[body.first], body.count);
  const auto index = std::size_t(body.id.index);
  if (body.id.kind == BodyKind::kSfem) {
    contact::tick(ticks.world->sfem_bodies[index].touch, *ticks.exchanges->sfem[index], commands,
                  ticks.period, readings);
  } else if (body.id.kind == BodyKind::kRhombus) {
    RhombusBody& rhombus = ticks.world->rhombus_bodies[index];
    contact::tick(rhombus.model, rhombus.touch, *ticks.exchanges->rhombus[index], commands, ticks.period,
                  readings);
  } else {
    for (std::size_t t = 0; t < body.count; t++) tick_local(ticks, body.first + t);
  }
}

void log_body(LiveTicks& ticks, const TickedBody& body) {
  for (std::size_t t = 0; t < body.count; t++) {
    const std::size_t slot = body.first + t;
    TouchingTool& tool = ticks.tools[std::size_t(ticks.order[slot].index)];
    const ForceSample sample = sample_of(ticks.time(), ticks.commands[slot], ticks.readings[slot]);
    if (body.id.kind == BodyKind::kSfem)
      log_tick(ticks.world->sfem_bodies[std::size_t(body.id.index)], t, sample, tool);
    else if (body.id.kind == BodyKind::kRhombus)
      log_tick(ticks.world->rhombus_bodies[std::size_t(body.id.index)], t, sample, tool);
    else
      tool.samples.append(sample);
  }
}

/// The loop's model: every tool of the world, whether a hand holds it or a path.
void tick_all(void* context, std::span<const contact::ToolCommand> hands, double /*dt*/,
              std::span<contact::ToolReading> felt) {
  LiveTicks& ticks = *static_cast<LiveTicks*>(context);
  ticks.done++;
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++) {
    const TickedTool& ticked = ticks.order[slot];
    ticks.commands[slot] = command_of(ticks, ticked, ticks.tools[std::size_t(ticked.index)], hands);
    ticks.readings[slot] = {};
  }
  for (const TickedBody& body : ticks.bodies) {
    tick_body(ticks, body);
    log_body(ticks, body);
  }
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    if (ticks.order[slot].hand >= 0) felt[std::size_t(ticks.order[slot].hand)] = ticks.readings[slot];
}

Exchanges make_exchanges(const World& world) {
  Exchanges exchanges;
  for (const SfemBody& body : world.sfem_bodies) {
    exchanges.sfem.push_back(std::make_unique<contact::SfemExchange>());
    if (!body.tool_indices.empty()) contact::prepare(body.touch, *exchanges.sfem.back());
  }
  for (const RhombusBody& body : world.rhombus_bodies) {
    exchanges.rhombus.push_back(std::make_unique<latest<contact::RhombusTouchedNow>>());
    contact::prepare(body.touch, *exchanges.rhombus.back());
  }
  for (const TouchingTool& tool : world.tools) {
    exchanges.local.emplace_back();
    if (tool.body.kind != BodyKind::kLattice && tool.body.kind != BodyKind::kCloth) continue;
    exchanges.local.back() = std::make_unique<LocalExchange>();
    exchanges.local.back()->before = command_at(tool, 0);
    exchanges.local.back()->command.write(command_at(tool, 0));
  }
  return exchanges;
}

void add_bodies(const World& world, const std::vector<HeldTool>& held, LiveTicks& ticks) {
  for_each_touched(world, [&](BodyId id, const auto& body) {
    if (body.tool_indices.empty()) return;
    ticks.bodies.push_back({id, ticks.order.size(), body.tool_indices.size()});
    for (const int tool : body.tool_indices) {
      const auto holder =
          std::find_if(held.begin(), held.end(), [tool](const HeldTool& h) { return h.tool == tool; });
      TickedTool& ticked = ticks.order.emplace_back();
      ticked.index = tool;
      if (holder == held.end()) continue;
      ticked.hand = int(holder - held.begin());
      ticked.has_grip = holder->hand.device->spec().has_grip;
    }
  });
  ticks.commands.resize(ticks.order.size());
  ticks.readings.resize(ticks.order.size());
}

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
  Exchanges exchanges;
  LiveTicks ticks;
  std::unique_ptr<haptics::Loop> loop;
  std::optional<double> began;  // the first frame [s]
  int first_frame = 0;
  FrameTiming frames;
  bool stopped = false;
};

LiveTouch::LiveTouch(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

LiveTouch::~LiveTouch() { stop(); }

Result<std::unique_ptr<LiveTouch>> LiveTouch::start(World& world, std::vector<HeldTool> held,
                                                    const LiveParams& params) {
  if (Status status = check_held(world, held); !status) return status.error();
  auto parts = std::make_unique<Parts>(Parts{.world = world, .exchanges = make_exchanges(world)});
  LiveTicks& ticks = parts->ticks;
  ticks.world = &world, ticks.exchanges = &parts->exchanges, ticks.period = 1 / params.loop.rate;
  ticks.tools = world.tools;
  for (TouchingTool& tool : ticks.tools)
    tool.samples.preallocate(std::min(kMostTicks, std::size_t(std::ceil(params.longest / ticks.period)) + 1));
  add_bodies(world, held, ticks);
  std::vector<haptics::Hand> hands;
  for (HeldTool& one : held) hands.push_back(std::move(one.hand));
  world.felt = &parts->exchanges;
  parts->first_frame = world.frame;
  Result<std::unique_ptr<haptics::Loop>> loop =
      haptics::Loop::start(std::move(hands), tick_all, &ticks, params.loop);
  if (!loop) {
    world.felt = nullptr;
    return loop.error();
  }
  parts->loop = std::move(*loop);
  return std::unique_ptr<LiveTouch>(new LiveTouch(std::move(parts)));
}

void LiveTouch::wait_for_frame() {
  Parts& p = *parts_;
  if (!p.began) p.began = haptics::steady_seconds() - p.world.dt;  // that of one frame has just been made
  const double due = *p.began + (p.world.frame - p.first_frame) * p.world.dt;
  haptics::sleep_until(due);
  const double late = haptics::steady_seconds() - due;
  p.frames.frames++;
  p.frames.late += late > p.world.dt;
  p.frames.latest = std::max(p.frames.latest, late);
}

void LiveTouch::stop() {
  Parts& p = *parts_;
  if (p.stopped) return;
  p.stopped = true;
  p.loop->stop();
  p.world.felt = nullptr;
  p.world.tools = std::move(p.ticks.tools);  // with the ways of their own that frames had in place of hands
}

const haptics::TimingReport& LiveTouch::timing() { return parts_->loop->report(); }

FrameTiming LiveTouch::frames() const { return parts_->frames; }

std::vector<std::string> LiveTouch::notes() const { return parts_->loop->notes(); }

}  // namespace turgor
