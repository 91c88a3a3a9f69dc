#include "turgor/contact/sfem_touch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

/// Interpolates values of coarse vertices at a patch point.
template <class Value>
Vec3d at_point(const sfem::Patch& patch, const sfem::PatchPoint& point, const Value& of_vertex) {
  TURGOR_CHECK(is_index(point.supports, point.coarse.size() + 1), "the supports of a point fit its storage");
  Vec3d sum;
  for (std::size_t s = 0; s < std::size_t(point.supports); s++)
    sum += of_vertex(std::size_t(patch.coarse[std::size_t(point.coarse[s])])) * point.weight[s];
  return sum;
}

/// Sets the patch points' displacements without tools.
void set_offsets(SfemTouch& touch) {
  FreeMotionInterpolation& path = touch.free;
  touch.free_step = 0;
  if (!path.moves) return;
  TURGOR_CHECK(path.ticks > 0 && path.from.size() == path.to.size(),
               "a motion has a start and an end for every vertex");
  // advance the interpolation
  const double before = path_fraction(path);
  path.done = std::min(path.done + 1, path.ticks);
  const double fraction = path_fraction(path);
  touch.free_step = fraction - before;
  for (std::size_t p = 0; p < touch.patch->points.size(); p++) {
    const auto moved = [&](std::size_t v) { return interpolated_motion(path, v, fraction); };
    Vec3d offset = at_point(*touch.patch, touch.patch->points[p], moved);
    if (!touch.patch->shift.empty()) offset += touch.patch->shift[p];
    touch.state.offset[p] = offset;
  }
}

/// Motion of a site in the present tick that contact does not cause [m].
Vec3d free_motion_of(const SfemTouch& touch, const Site& site) {
  Vec3d motion;
  if (touch.free_step == 0) return motion;
  const auto moved = [&](std::size_t v) { return (touch.free.to[v] - touch.free.from[v]) * touch.free_step; };
  visit_points(*touch.patch, site, [&](std::size_t p, double weight) {
    motion += at_point(*touch.patch, touch.patch->points[p], moved) * weight;
  });
  return motion;
}

ToolReading reading_of(const SfemTouch& touch, std::size_t tool) {
  const ToolForce& force = touch.forces[tool];
  ToolReading reading{.force = force.force * touch.stiffness_scale,
                      .torque = force.torque * touch.stiffness_scale,
                      .contacts = force.contacts,
                      .beyond_patch = force.beyond_patch};
  if (force.contacts > 0)
    reading.depth =
        depth_at_rest(*touch.patch, touch.state.surface, touch.tools[tool].shape, touch.poses[tool].pose);
  return reading;
}

/// Contact of a tool with the rough surface. Normal and motion of the surface are the means of the tool's
/// sites by their force. A tool slides where more than half of its normal force is borne by sites that slip.
/// Deformation by contact is no motion: it sticks to the tool, or is steady while the tool slides.
TextureContact texture_contact(const SfemTouch& touch, std::size_t t) {
  Vec3d normal, motion;
  double borne = 0, slipping = 0;
  for (const Site& site : touch.state.sites) {
    if (site.tool != int(t) || !bears_force(site)) continue;
    const double load = dot(site.force, site.normal);
    normal += site.normal * load;
    motion += load * free_motion_of(touch, site);
    borne += load, slipping += site.state == SiteState::kSlip ? load : 0;
  }
  const Vec3d position = touch.poses[t].pose.position;
  const Vec3d slid = position - touch.tools_before[t] - (borne > 0 ? motion / borne : Vec3d{});
  const double force = norm(normal);
  return {.point = slid_point(touch.textures[t], position, slid),
          .normal = force > 0 ? normal / force : Vec3d{},
          .force = force * touch.stiffness_scale,
          .is_slip = slipping > 0.5 * borne && !touch.forces[t].invalid_pose && !touch.poses[t].hold};
}

/// Vector from a tool's origin to the mean of its sites by their normal force, where a vibration acts [m].
Vec3d arm_of(const SfemTouch& touch, std::size_t t) {
  Vec3d arm;
  double borne = 0;
  for (const Site& site : touch.state.sites) {
    if (site.tool != int(t) || !bears_force(site)) continue;
    const double load = dot(site.force, site.normal);
    arm += load * (weighted(*touch.patch, site, touch.state.x) - touch.poses[t].pose.position);
    borne += load;
  }
  return borne > 0 ? arm / borne : Vec3d{};
}

/// Displacement of the vertices around a needle that it does not cause.
void set_needle_motion(NeedleState& needle) {
  FreeMotionInterpolation& path = needle.motion;
  if (!path.moves) return;
  path.done = std::min(path.done + 1, path.ticks);
  const double fraction = path_fraction(path);
  for (std::size_t v = 0; v < needle.free.size(); v++)
    needle.free[v] = interpolated_motion(path, v, fraction);
}

/// Ticks the tools that are needles.
void tick_needles(SfemTouch& touch, std::span<ToolReading> readings) {
  if (!touch.needles.inner) return;
  for (std::size_t t = 0; t < touch.tools.size(); t++) {
    if (!touch.tools[t].needle) continue;
    NeedleState& needle = touch.needles.needles[t];
    set_needle_motion(needle);
    const std::span<const Vec3d> free =
        needle.motion.moves ? std::span<const Vec3d>(needle.free) : std::span<const Vec3d>();
    readings[t] = tick_needle(*touch.needles.inner, *touch.tools[t].needle, free, touch.poses[t].pose,
                              touch.stiffness_scale, needle);
    ToolForce& force = touch.forces[t];
    force.force = readings[t].force / touch.stiffness_scale;
    force.torque = readings[t].torque / touch.stiffness_scale;
    force.contacts = readings[t].contacts, force.beyond_patch = readings[t].beyond_patch;
  }
}

}  // namespace

SfemTouch make_sfem_touch(std::shared_ptr<const sfem::Patch> patch, std::vector<Tool> tools,
                          std::span<const Pose> poses, const SfemTouchParams& params) {
  TURGOR_ASSERT(poses.size() == tools.size(), "one pose a tool");
  TURGOR_ASSERT(patch != nullptr, "a touch has a patch");
  SfemTouch touch{.patch = std::move(patch), .tools = std::move(tools), .follow = params.follow};
  const std::size_t spare = 2 * touch.patch->points.size() + 64;  // later patches have about the same size
  touch.state = make_touch_state(*touch.patch, touch.tools.size(), params.touch, spare);
  for (std::size_t i = 0; i < std::size_t(touch.state.history.count); i++)
    touch.state.history.pairs[i].far.reserve(params.vertex_count);
  touch.free.from.resize(params.vertex_count);
  touch.free.to.resize(params.vertex_count);
  touch.texture = params.texture;
  touch.textures.resize(touch.tools.size()), touch.tools_before.resize(touch.tools.size());
  for (const Pose& pose : poses) touch.poses.push_back({pose, false});
  touch.forces.resize(touch.tools.size());
  return touch;
}

void tick_sfem_touch(SfemTouch& touch, std::span<const ToolCommand> commands, double dt,
                     std::span<ToolReading> readings) {
  TURGOR_ASSERT(commands.size() == touch.tools.size() && readings.size() == touch.tools.size(),
                "one command and one reading a tool");
  // poses and free motion of this tick
  for (std::size_t t = 0; t < commands.size(); t++) {
    touch.tools_before[t] = touch.poses[t].pose.position;
    touch.poses[t] = {commands[t].pose, commands[t].hold};
  }
  set_offsets(touch);
  // contact forces
  contact::solve_touch_tick(*touch.patch, touch.state, touch.tools, touch.poses, dt, touch.forces);
  blend(touch.follow, touch.state, dt, touch.forces);
  // readings
  for (std::size_t t = 0; t < commands.size(); t++) {
    readings[t] = reading_of(touch, t);
    if (!is_rough(touch.texture)) continue;
    const Vec3d vibration = texture_force(touch.texture, touch.textures[t], texture_contact(touch, t), dt);
    readings[t].force += vibration, readings[t].torque += cross(arm_of(touch, t), vibration);
  }
  tick_needles(touch, readings);
  touch.ticks++;
}

void set_viscosity(SfemTouch& touch, const Prony& viscosity) {
  TouchState& state = touch.state;
  if (state.params.viscosity == viscosity) return;
  change_pairs(state.params.viscosity, viscosity, state.u, state.force, state.history);
  state.params.viscosity = viscosity;
}

void reserve_viscosity(SfemTouch& touch) {
  const std::size_t points = touch.state.x.capacity();
  touch.state.match.history.reserve(points);
  for (PairHistory& pair : touch.state.history.pairs) {
    for (auto* list : {&pair.v, &pair.phi}) list->reserve(points);
    pair.far.reserve(touch.free.to.size());
  }
}

void start_motion(FreeMotionInterpolation& path, std::span<const Vec3d> to, long ticks) {
  if (to.empty()) return;
  TURGOR_ASSERT(to.size() == path.to.size(), "one free motion a vertex");
  // start from the present value of the interpolation
  if (path.done >= path.ticks || !path.moves)
    std::swap(path.from, path.to);
  else
    for (std::size_t v = 0; v < to.size(); v++)
      path.from[v] = interpolated_motion(path, v, path_fraction(path));
  std::copy(to.begin(), to.end(), path.to.begin());
  path.moves = true;
  path.ticks = std::max(1l, ticks), path.done = 0;
}

void take_free_motion(SfemTouch& touch, std::span<const Vec3d> to, long ticks) {
  start_motion(touch.free, to, ticks);
}

Handover take_patch(SfemTouch& touch, const FinishedPatch& offer) {
  TURGOR_ASSERT(offer.patch != nullptr, "an offered patch was built");
  touch.handover = take_patch(touch.state, *touch.patch, *offer.patch, touch.tools, offer.history);
  touch.patch = offer.patch;
  touch.patch_number = offer.number, touch.solution_tick = 0;
  return touch.handover;
}

void take_solution(SfemTouch& touch, const PatchSolution& solution) {
  if (!solution.patch || solution.base != touch.patch_number) return;
  TURGOR_CHECK(solution.patch->points.size() == touch.patch->points.size(),
               "a solution has the points of its patch");
  take_patch(touch.state, *touch.patch, *solution.patch, touch.tools);
  touch.patch = solution.patch, touch.solution_tick = solution.tick;
}

void publish(const SfemTouch& touch, SfemTouchSnapshot& now) {
  // patch and deformation
  now.patch = touch.patch;
  now.patch_number = touch.patch_number;
  now.ticks = touch.ticks;
  now.force_jump = touch.handover.force_jump;
  now.x = touch.state.x;
  now.force = touch.state.force;
  now.history = touch.state.history;
  now.viscosity = touch.state.params.viscosity;
  now.stiffness_scale = touch.stiffness_scale;
  // tools, with forces scaled to the body's stiffness
  now.poses = touch.poses;
  now.forces = touch.forces;
  for (ToolForce& force : now.forces)
    force.force *= touch.stiffness_scale, force.torque *= touch.stiffness_scale;
  // contact centers
  now.contact_centers.resize(touch.tools.size());
  find_contact_centers(*touch.patch, touch.state, now.contact_centers);
  now.textures = touch.textures;
  // forces of needles
  if (!touch.needles.inner) return;
  now.inner = touch.needles.inner;
  list_track_elements(touch.needles, now.track_elements);
  now.needle_forces.resize(touch.tools.size());
  for (std::size_t t = 0; t < touch.tools.size(); t++) {
    if (!touch.tools[t].needle) continue;
    now.needle_forces[t].assign(touch.needles.inner->vertices.size(), {});
    add_needle_forces(*touch.needles.inner, touch.needles.needles[t], now.needle_forces[t]);
  }
}

void reserve_like(const SfemTouch& touch, SfemTouchSnapshot& now) {
  for (auto* points : {&now.x, &now.force}) points->reserve(touch.state.x.capacity());
  for (std::size_t i = 0; i < std::size_t(kMostPronyPairs); i++) {
    PairHistory& pair = now.history.pairs[i];
    for (auto* points : {&pair.v, &pair.phi}) points->reserve(touch.state.history.pairs[i].v.capacity());
    pair.far.reserve(touch.state.history.pairs[i].far.capacity());
  }
  // needles, for Green's functions of all vertices
  if (touch.needles.inner) {
    now.needle_forces.resize(touch.tools.size());
    now.track_elements.reserve(touch.tools.size() * kMostTracks * kMostNeedlePoints);
    for (std::size_t t = 0; t < touch.tools.size(); t++)
      if (touch.tools[t].needle) now.needle_forces[t].reserve(touch.free.to.size());
  }
  publish(touch, now);
}

void prepare(const SfemTouch& touch, SfemExchange& exchange) {
  for (int slot = 0; slot < 3; slot++) {  // each slot of latest<> passes the writer once
    reserve_like(touch, exchange.touched.writing());
    exchange.touched.publish();
    exchange.touched.read();
    exchange.forces.writing().force.reserve(touch.state.x.capacity());
    exchange.forces.publish();
    exchange.forces.read();
  }
}

namespace {

/// Number of ticks of `dt` seconds in a frame of so many ticks of 1 ms.
long ticks_of_frame(long milliseconds, double dt) {
  TURGOR_CHECK(dt > 0, "a tick has a positive length");
  return std::max(1l, std::lround(double(milliseconds) * 1e-3 / dt));
}

/// Publishes the forces for the solver of the patch.
void publish_forces(const SfemTouch& touch, latest<LawForces>& forces) {
  LawForces& now = forces.writing();
  now.patch_number = touch.patch_number, now.solution_tick = touch.solution_tick;
  now.ticks = touch.ticks;
  now.force = touch.state.force, now.stiffening = touch.stiffening;
  forces.publish();
}

}  // namespace

void tick_with_exchange(SfemTouch& touch, SfemExchange& exchange, std::span<const ToolCommand> commands,
                        double dt, std::span<ToolReading> readings) {
  // newest free motion and parameters
  if (exchange.motion.has_news()) {
    const FreeMotion& motion = exchange.motion.read();
    const long ticks = ticks_of_frame(motion.ticks, dt);
    take_free_motion(touch, motion.to, ticks);
    if (motion.inner && motion.inner != touch.needles.inner)
      take_inner(touch, motion.inner, motion.of_needles);
    take_needle_motion(touch, motion.of_needles, ticks);
    touch.motion_number = motion.number, touch.stiffness_scale = motion.stiffness_scale;
    touch.texture.waves = motion.waves;
    if (motion.viscosity) set_viscosity(touch, *motion.viscosity);
    if (motion.stiffening) touch.stiffening = *motion.stiffening;
    TURGOR_ASSERT(motion.friction.size() <= touch.tools.size(), "at most one friction a tool");
    for (std::size_t t = 0; t < motion.friction.size(); t++) touch.tools[t].friction = motion.friction[t];
  }
  // newest patch, and its newest solution
  if (exchange.patches.has_news()) take_patch(touch, exchange.patches.read());
  if (exchange.solutions.has_news()) take_solution(touch, exchange.solutions.read());
  // tick and publish
  tick_sfem_touch(touch, commands, dt, readings);
  publish(touch, exchange.touched.writing());
  exchange.touched.publish();
  if (exchange.is_solved) publish_forces(touch, exchange.forces);
}

}  // namespace turgor::contact
