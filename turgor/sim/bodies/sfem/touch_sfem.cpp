#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/surface_strain.hpp"
#include "turgor/sim/bodies/sfem/choose_patch.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/bodies/sfem/needle_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

void log_tick(const SfemBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool) {
  const contact::ToolForce& haptic = body.touch.forces[t];
  tool.limits.coarsest = std::max(tool.limits.coarsest, haptic.contacts > 0 ? haptic.level : 0);
  tool.limits.dropped_most = std::max(tool.limits.dropped_most, haptic.dropped);
  tool.limits.dropped_ticks += haptic.dropped > 0;
  tool.limits.unsolved_ticks += haptic.contacts > 0 && !body.touch.state.solution.converged;
  ForceSample logged = sample;
  if (body.touch.tools[t].needle) {
    const contact::NeedleState& needle = body.touch.needles.needles[t];
    logged.needle = needle.reading;
    tool.needle_work = needle.work, tool.punctures = needle.punctures, tool.entry_force = needle.entry_force;
  }
  tool.samples.append(logged);
}

Status begin_touch(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                   const Prony& viscosity) {
  if (body.tool_indices.empty()) return Done{};

  // tools at their initial poses
  std::vector<contact::Tool> shapes;
  std::vector<contact::Pose> poses;
  const RestSurface surface{body.model.body.mesh.vertices, body.model.surface.triangles};
  for (const int t : body.tool_indices) {
    TURGOR_CHECK(is_index(t, tools.size()), "a body is touched by tools of its world");
    const TouchingTool& tool = tools[std::size_t(t)];
    shapes.push_back(tool.tool);
    poses.push_back(command_at(tool, 0).pose);
    const Vec3d position = contact::tool_position(tool.tool.shape, poses.back());
    body.centers.push_back(sample_surface(surface, position, false, body.follow.radius).point);
  }

  // first patch and touch state
  choose_patch(body, tools);
  Result<std::shared_ptr<const sfem::Patch>> patch = first_patch(exec, body);
  if (!patch) return patch.error();
  body.touch = contact::make_sfem_touch(std::move(*patch), std::move(shapes), poses,
                                        {.touch = {.capacity = body.contacts, .viscosity = viscosity},
                                         .follow = body.follow,
                                         .vertex_count = body.model.body.mesh.vertices.size(),
                                         .texture = body.texture});
  body.touch.stiffness_scale = body.stiffness_scale;
  contact::publish(body.touch, body.now);
  return Done{};
}

void touch_body(const Exec& exec, SfemBody& body, std::vector<TouchingTool>& tools, double from, double to) {
  if (body.tool_indices.empty()) return;
  TURGOR_CHECK(to >= from, "ticks do not run backwards");
  std::vector<contact::ToolCommand> commands(body.tool_indices.size());
  std::vector<contact::ToolReading> readings(commands.size());
  const auto tool_of = [&](std::size_t t) -> TouchingTool& {
    return tools[std::size_t(body.tool_indices[t])];
  };

  // ticks of this frame
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  const long patch_ticks =
      std::min(kPatchTicks, last - first);  // a patch is requested and used within one frame
  std::optional<NextPatch> next;
  contact::take_free_motion(body.touch, body.free.now, last - first + 1);
  if (body.needles.inner != body.touch.needles.inner)
    contact::take_inner(body.touch, body.needles.inner, body.needles.motion);
  contact::take_needle_motion(body.touch, body.needles.motion, last - first + 1);
  body.touch.stiffness_scale = body.stiffness_scale;
  body.touch.texture = body.texture;
  contact::set_viscosity(body.touch, body.viscosity);

  // commands
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    for (std::size_t t = 0; t < commands.size(); t++) commands[t] = next_command(tool_of(t), time, kTick);

    // patch
    bool new_patch = false;
    if (!next && tick + patch_ticks <= last) next = follow_tools(exec, body, commands, tick + patch_ticks);
    if (!next && tick + patch_ticks <= last) next = solve_law(body, tick + patch_ticks);
    if (next && next->due == tick) new_patch = take_next_patch(body, *next, time), next.reset();

    // tick and log
    const Timer timer;
    contact::tick_sfem_touch(body.touch, commands, kTick, readings);
    const double seconds = timer.seconds();
    for (std::size_t t = 0; t < commands.size(); t++) {
      ForceSample sample = sample_of(time, commands[t], readings[t]);
      sample.tick_seconds = float(seconds), sample.new_patch = new_patch;
      log_tick(body, t, sample, tool_of(t));
    }
  }

  // results for the frame
  contact::publish(body.touch, body.now);
  read_touch_snapshot(body);
}

void read_touch_snapshot(SfemBody& body) {
  if (!body.turning && body.now.x.size() == body.now.patch->points.size())
    body.surface_strain =
        std::max(body.surface_strain, sfem::largest_surface_strain(*body.now.patch, body.now.x));
  TURGOR_CHECK(body.now.patch_number >= 0, "patches are counted from 1");
  if (const auto taken = std::size_t(body.now.patch_number); taken > 0 && taken <= body.rebuilds.size())
    body.rebuilds[taken - 1].force_jump = body.now.force_jump;
}

void make_frame(const Exec& exec, SfemBody& body, double time, double frame_dt,
                contact::SfemExchange& exchange) {
  if (body.tool_indices.empty()) return correct_rotations(exec, body);

  TURGOR_CHECK(is_step_length(frame_dt), "a frame has a positive length");
  // results of the ticks
  body.now = exchange.touched.read();
  read_touch_snapshot(body);
  collect_solutions(body);
  follow_needles(exec, body);
  correct_rotations(exec, body);
  contact::FreeMotion& motion = exchange.motion.writing();
  motion.to = body.free.now, motion.of_needles = body.needles.motion;
  motion.inner = body.needles.inner;
  motion.ticks = std::max(1l, std::lround(frame_dt / kTick));
  motion.number = ++body.free.number;
  motion.stiffness_scale = body.stiffness_scale, motion.friction = body.friction;
  motion.waves = body.texture.waves;
  motion.viscosity = body.viscosity;
  if (body.law) motion.stiffening = body.law->stiffening;
  exchange.motion.publish();
  offer_patch(exec, body, time, exchange.patches);
}

}  // namespace turgor
