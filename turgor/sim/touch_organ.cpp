#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/timing.hpp"
#include "turgor/sim/organ.hpp"
#include "turgor/sim/organ_patch.hpp"
#include "turgor/sim/press_path.hpp"

namespace turgor {

namespace {

contact::ToolPose pose_at(const ToolPath& path, double time) {
  const PathRow row = path_at(path, time);
  return {{row.position, axes_of(row.orientation)}, row.hold};
}

void set_poses(Organ& organ, const std::vector<TouchingTool>& tools, double time) {
  for (std::size_t t = 0; t < organ.tool_indices.size(); t++)
    organ.poses[t] = pose_at(tools[std::size_t(organ.tool_indices[t])].path, time);
}

/// Where turned elements and cloth have brought the points, a part of the way from the last frame's to this
/// one's.
void set_offsets(Organ& organ, double part) {
  const auto& [before, now] = organ.free;
  if (now.empty()) return;
  for (std::size_t p = 0; p < organ.patch.points.size(); p++) {
    const sfem::PatchPoint& point = organ.patch.points[p];
    Vec3d offset;
    for (int s = 0; s < point.supports; s++) {
      const auto i = std::size_t(s);
      const auto v = std::size_t(organ.patch.coarse[std::size_t(point.coarse[i])]);
      offset += (before[v] * (1 - part) + now[v] * part) * point.weight[i];
    }
    organ.touch.offset[p] = offset;
  }
}

void record_tick(const Organ& organ, std::vector<TouchingTool>& tools, ForceSample common) {
  for (std::size_t t = 0; t < organ.tool_indices.size(); t++) {
    const contact::ToolForce& felt = organ.forces[t];
    ForceSample sample = common;
    sample.position = organ.poses[t].pose.position;
    sample.force = felt.force, sample.torque = felt.torque;
    sample.contacts = felt.contacts;
    sample.beyond_patch = felt.beyond_patch;
    if (felt.contacts > 0) sample.depth = depth_at_rest(organ, organ.tools[t], organ.poses[t].pose);
    TouchingTool& tool = tools[std::size_t(organ.tool_indices[t])];
    tool.limits.coarsest = std::max(tool.limits.coarsest, felt.contacts > 0 ? felt.level : 0);
    tool.limits.dropped_most = std::max(tool.limits.dropped_most, felt.dropped);
    tool.limits.dropped_ticks += felt.dropped > 0;
    std::vector<ForceSample>& samples = tool.samples;
    if (!samples.empty()) sample.path = samples.back().path + norm(sample.position - samples.back().position);
    samples.push_back(sample);
  }
}

/// How far a place is above the surface of the patch at rest; negative inside [m].
double height_at_rest(const sfem::Patch& patch, const contact::PatchSurface& surface, Vec3d x) {
  Vec3d apart, normal;
  double nearest = std::numeric_limits<double>::max();
  for (const Int3 t : patch.triangles) {
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Vec3d w = contact::closest_weights(x, patch.points[a].x, patch.points[b].x, patch.points[c].x);
    const Vec3d d = x - (patch.points[a].x * w.x + patch.points[b].x * w.y + patch.points[c].x * w.z);
    if (norm(d) >= nearest) continue;
    nearest = norm(d), apart = d;
    normal = surface.normal[a] * w.x + surface.normal[b] * w.y + surface.normal[c] * w.z;
  }
  return dot(apart, normal) < 0 ? -nearest : nearest;
}

}  // namespace

double depth_at_rest(const Organ& organ, const contact::Tool& tool, const contact::Pose& pose) {
  constexpr int kMostTips = 16;  // of a mesh tool
  const int tips = contact::tip_count(tool.shape), stride = std::max(1, tips / kMostTips);
  double deepest = 0;
  for (int n = 0; n < tips; n += stride) {
    const Vec3d tip = contact::tip(tool.shape, n);
    const double radius = -contact::distance(tool.shape, tip).distance;  // of a ball around it in the tool
    const double height = height_at_rest(organ.patch, organ.touch.surface, contact::to_world(pose, tip));
    deepest = std::max(deepest, radius - height);
  }
  return deepest;
}

Status begin_touch(const Exec& exec, Organ& organ, const std::vector<TouchingTool>& tools,
                   const contact::Viscosity& viscosity) {
  for (const int t : organ.tool_indices) organ.tools.push_back(tools[std::size_t(t)].tool);
  if (organ.tools.empty()) return Done{};
  organ.poses.resize(organ.tools.size());
  organ.forces.resize(organ.tools.size());
  set_poses(organ, tools, 0);
  const RestSurface surface{organ.model.body.mesh.vertices, organ.model.surface.triangles};
  for (const contact::ToolPose& pose : organ.poses)
    organ.centres.push_back(place_on_surface(surface, pose.pose.position, false, organ.follow.radius).point);
  Result<sfem::Patch> patch = first_patch(exec, organ);
  if (!patch) return patch.error();
  organ.patch = std::move(*patch);
  const std::size_t spare = 2 * organ.patch.points.size() + 64;  // later patches are about as large
  organ.touch = contact::make_touch_state(organ.patch, organ.tools.size(),
                                          {.capacity = organ.contacts, .viscosity = viscosity}, spare);
  return Done{};
}

void touch_organ(const Exec& exec, Organ& organ, std::vector<TouchingTool>& tools, double from, double to) {
  if (organ.tools.empty()) return;
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  const long patch_ticks = std::min(kPatchTicks, last - first);  // a patch is wanted and taken within a frame
  std::optional<NextPatch> next;
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    set_poses(organ, tools, time);
    ForceSample common{.time = time};
    if (!next && tick + patch_ticks <= last) next = follow_tools(exec, organ, tick + patch_ticks);
    if (next && next->due == tick) common.new_patch = take_next_patch(organ, *next, time), next.reset();
    set_offsets(organ, double(tick - first + 1) / double(last - first + 1));
    const Timer timer;
    contact::touch(organ.patch, organ.touch, organ.tools, organ.poses, kTick, organ.forces);
    contact::blend(organ.follow, organ.touch, kTick, organ.forces);
    common.tick_seconds = float(timer.seconds());
    record_tick(organ, tools, common);
  }
}

void remember_deepest(const Exec& exec, Organ& organ, double time) {
  double force = 0;
  for (const contact::ToolForce& felt : organ.forces) force += norm(felt.force);
  if (force <= organ.largest_force) return;
  organ.largest_force = force;
  organ.deepest = shown_surface(exec, organ, time);
}

}  // namespace turgor
