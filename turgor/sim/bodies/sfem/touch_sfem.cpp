#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/timing.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

namespace {

contact::ToolPose pose_at(const ToolPath& path, double time) {
  const PathRow row = path_at(path, time);
  return {{row.position, axes_of(row.orientation)}, row.hold};
}

void set_poses(SfemBody& body, const std::vector<TouchingTool>& tools, double time) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++)
    body.poses[t] = pose_at(tools[std::size_t(body.tool_indices[t])].path, time);
}

/// Where turned elements and cloth have brought the points, a part of the way from the last frame's to this
/// one's.
void set_offsets(SfemBody& body, double part) {
  const auto& [before, now] = body.free;
  if (now.empty()) return;
  for (std::size_t p = 0; p < body.patch.points.size(); p++) {
    const sfem::PatchPoint& point = body.patch.points[p];
    Vec3d offset;
    for (int s = 0; s < point.supports; s++) {
      const auto i = std::size_t(s);
      const auto v = std::size_t(body.patch.coarse[std::size_t(point.coarse[i])]);
      offset += (before[v] * (1 - part) + now[v] * part) * point.weight[i];
    }
    body.touch.offset[p] = offset;
  }
}

void record_tick(const SfemBody& body, std::vector<TouchingTool>& tools, ForceSample common) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const contact::ToolForce& felt = body.forces[t];
    ForceSample sample = common;
    sample.position = body.poses[t].pose.position;
    sample.force = felt.force, sample.torque = felt.torque;
    sample.contacts = felt.contacts;
    sample.beyond_patch = felt.beyond_patch;
    if (felt.contacts > 0) sample.depth = depth_at_rest(body, body.tools[t], body.poses[t].pose);
    TouchingTool& tool = tools[std::size_t(body.tool_indices[t])];
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

double depth_at_rest(const SfemBody& body, const contact::Tool& tool, const contact::Pose& pose) {
  constexpr int kMostTips = 16;  // of a mesh tool
  const int tips = contact::tip_count(tool.shape), stride = std::max(1, tips / kMostTips);
  double deepest = 0;
  for (int n = 0; n < tips; n += stride) {
    const Vec3d tip = contact::tip(tool.shape, n);
    const double radius = -contact::distance(tool.shape, tip).distance;  // of a ball around it in the tool
    const double height = height_at_rest(body.patch, body.touch.surface, contact::to_world(pose, tip));
    deepest = std::max(deepest, radius - height);
  }
  return deepest;
}

Status begin_touch(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                   const contact::Viscosity& viscosity) {
  for (const int t : body.tool_indices) body.tools.push_back(tools[std::size_t(t)].tool);
  if (body.tools.empty()) return Done{};
  body.poses.resize(body.tools.size());
  body.forces.resize(body.tools.size());
  set_poses(body, tools, 0);
  const RestSurface surface{body.model.body.mesh.vertices, body.model.surface.triangles};
  for (const contact::ToolPose& pose : body.poses)
    body.centres.push_back(place_on_surface(surface, pose.pose.position, false, body.follow.radius).point);
  Result<sfem::Patch> patch = first_patch(exec, body);
  if (!patch) return patch.error();
  body.patch = std::move(*patch);
  const std::size_t spare = 2 * body.patch.points.size() + 64;  // later patches are about as large
  body.touch = contact::make_touch_state(body.patch, body.tools.size(),
                                         {.capacity = body.contacts, .viscosity = viscosity}, spare);
  return Done{};
}

void touch_body(const Exec& exec, SfemBody& body, std::vector<TouchingTool>& tools, double from, double to) {
  if (body.tools.empty()) return;
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  const long patch_ticks = std::min(kPatchTicks, last - first);  // a patch is wanted and taken within a frame
  std::optional<NextPatch> next;
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    set_poses(body, tools, time);
    ForceSample common{.time = time};
    if (!next && tick + patch_ticks <= last) next = follow_tools(exec, body, tick + patch_ticks);
    if (next && next->due == tick) common.new_patch = take_next_patch(body, *next, time), next.reset();
    set_offsets(body, double(tick - first + 1) / double(last - first + 1));
    const Timer timer;
    contact::touch(body.patch, body.touch, body.tools, body.poses, kTick, body.forces);
    contact::blend(body.follow, body.touch, kTick, body.forces);
    common.tick_seconds = float(timer.seconds());
    record_tick(body, tools, common);
  }
}

}  // namespace turgor
