#include "turgor/sim/live/live_touch.hpp"

#include <algorithm>
#include <cmath>

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
  int index = 0;                              // into World::tools
  int hand = -1;                              // of the devices; -1: it goes on its path
  const std::atomic<bool>* is_led = nullptr;  // see HeldTool
  bool has_grip = false;
  contact::LocalTouch local;  // on bodies that are felt by the frame
  double plane_time = 0;      // when the newest plane came [s]
};

/// What the haptic thread owns, besides the touches of the bodies.
struct LiveTicks {
  World* world = nullptr;
  Exchanges* exchanges = nullptr;
  double period = kTick;            // [s]
  double began = 0;                 // the world's time when the pace was set [s]
  double step = kTick;              // of the world's time a tick [s]
  long done = 0;                    // ticks since then
  std::atomic<double> pace = 1;     // that the frame asks for
  std::atomic<long> left = -1;      // ticks that the frame allows yet; -1: all
  std::vector<TouchingTool> tools;  // as World::tools, whose paths, logs and grips it goes on with
  std::vector<TickedBody> bodies;
  std::vector<TickedTool> order;  // body by body, as the two below
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  latest<std::vector<contact::ToolReading>> felt;  // as World::tools

  double time() const { return began + double(done) * step; }
};

/// The hand's, with jaws that close while the button is held where the device has none.
contact::ToolCommand command_of(const LiveTicks& ticks, const TickedTool& ticked, TouchingTool& tool,
                                std::span<const contact::ToolCommand> hands) {
  if (ticked.hand < 0 || (ticked.is_led && !*ticked.is_led)) return next_command(tool, ticks.time());
  contact::ToolCommand command = hands[std::size_t(ticked.hand)];
  if (!ticked.has_grip)
    command.grip = contact::next_grip(tool.grip, command.hold, holding_time(tool), ticks.step);
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
  contact::tick(ticked.local, ticks.commands[slot], ticks.step, ticks.readings[slot]);
  ticks.readings[slot].age = ticks.time() - ticked.plane_time;
}

void tick_body(LiveTicks& ticks, const TickedBody& body) {
  const std::span<const contact::ToolCommand> commands(&ticks.commands[body.first], body.count);
  const std::span<contact::ToolReading> readings(&ticks.readings[body.first], body.count);
  const auto index = std::size_t(body.id.index);
  if (body.id.kind == BodyKind::kSfem) {
    contact::tick(ticks.world->sfem_bodies[index].touch, *ticks.exchanges->sfem[index], commands, ticks.step,
                  readings);
  } else if (body.id.kind == BodyKind::kRhombus) {
    RhombusBody& rhombus = ticks.world->rhombus_bodies[index];
    contact::tick(rhombus.model, rhombus.touch, *ticks.exchanges->rhombus[index], commands, ticks.step,
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

/// Does the world's time pass in this tick? Begins to count anew where its pace is another.
bool goes_on(LiveTicks& ticks) {
  const double step = ticks.period * ticks.pace;
  const long left = ticks.left;
  if (left == 0) return false;
  if (left > 0) ticks.left.fetch_sub(1);
  if (step != ticks.step) ticks.began = ticks.time(), ticks.done = 0, ticks.step = step;
  ticks.done++;
  return true;
}

/// What every tool feels, for whoever looks on.
void tell_felt(LiveTicks& ticks) {
  std::vector<contact::ToolReading>& felt = ticks.felt.writing();
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    felt[std::size_t(ticks.order[slot].index)] = ticks.readings[slot];
  ticks.felt.publish();
}

/// The loop's model: every tool of the world, whether a hand holds it or a path.
void tick_all(void* context, std::span<const contact::ToolCommand> hands, double /*dt*/,
              std::span<contact::ToolReading> felt) {
  LiveTicks& ticks = *static_cast<LiveTicks*>(context);
  for (contact::ToolReading& reading : felt) reading = {};
  if (!goes_on(ticks)) return;
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
  tell_felt(ticks);
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
      ticked.is_led = holder->is_led;
      ticked.has_grip = holder->hand.device->spec().has_grip;
    }
  });
  ticks.commands.resize(ticks.order.size());
  ticks.readings.resize(ticks.order.size());
  for (int slot = 0; slot < 3; slot++) {  // each of the three has its memory before the first tick
    ticks.felt.write(std::vector<contact::ToolReading>(world.tools.size()));
    ticks.felt.read();
  }
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
  FrameClock clock;
  bool stopped = false;
};

LiveTouch::LiveTouch(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

LiveTouch::~LiveTouch() { stop(); }

Result<std::unique_ptr<LiveTouch>> LiveTouch::start(World& world, std::vector<HeldTool> held,
                                                    const LiveParams& params) {
  if (Status status = check_held(world, held); !status) return status.error();
  std::unique_ptr<Parts> parts(new Parts{world, make_exchanges(world), {}, {}, FrameClock(world.dt)});
  LiveTicks& ticks = parts->ticks;
  ticks.world = &world, ticks.exchanges = &parts->exchanges, ticks.period = ticks.step = 1 / params.loop.rate;
  ticks.began = time_of(world);
  ticks.tools = world.tools;
  for (TouchingTool& tool : ticks.tools)
    tool.samples.preallocate(std::min(kMostTicks, std::size_t(std::ceil(params.longest / ticks.period)) + 1));
  add_bodies(world, held, ticks);
  std::vector<haptics::Hand> hands;
  for (HeldTool& one : held) hands.push_back(std::move(one.hand));
  world.felt = &parts->exchanges;
  Result<std::unique_ptr<haptics::Loop>> loop =
      haptics::Loop::start(std::move(hands), tick_all, &ticks, params.loop);
  if (!loop) {
    world.felt = nullptr;
    return loop.error();
  }
  parts->loop = std::move(*loop);
  return std::unique_ptr<LiveTouch>(new LiveTouch(std::move(parts)));
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

const std::vector<contact::ToolReading>& LiveTouch::felt() { return parts_->ticks.felt.read(); }

void LiveTouch::stop() {
  Parts& p = *parts_;
  if (p.stopped) return;
  p.stopped = true;
  p.loop->stop();
  p.world.felt = nullptr;
  p.world.tools = std::move(p.ticks.tools);  // with the ways of their own that frames had in place of hands
}

const haptics::TimingReport& LiveTouch::timing() { return parts_->loop->report(); }

FrameTiming LiveTouch::frames() const { return parts_->clock.timing(); }

std::vector<std::string> LiveTouch::notes() const { return parts_->loop->notes(); }

}  // namespace turgor
