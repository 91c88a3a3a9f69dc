// Snapshots of rigid bodies: the surface at rest, the motion and the tools, so that a replay needs no file of
// the scene.
#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/bodies/rigid/rigid_body.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/recording/recording_touch.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostRigidNumbers = std::size_t(1) << 28;

std::string group_of(const std::string& snapshot, const RigidBody& body) {
  return fmt::format("{}/bodies/{}/", snapshot, body.name);
}

}  // namespace

Status write_state(const SnapshotOut& out, const RigidBody& body, BodyId id) {
  const auto& [center, rotation, velocity, momentum] = body.state;
  const Vec3d rest = body.model.mass.center;
  std::vector<float> x;
  std::vector<int> triangles;
  for (const Vec3 v : body.drawn.vertices) x.insert(x.end(), {v.x, v.y, v.z});
  for (const Int3 t : body.drawn.triangles) triangles.insert(triangles.end(), {t.x, t.y, t.z});
  const Status status = Writing(out.file, group_of(out.group, body))
                            .array<float>("rest", x, 3, "m")
                            .array<int>("triangles", triangles, 3)
                            .array<double>("rest_center", {rest.x, rest.y, rest.z}, 1, "m")
                            .array<double>("center", {center.x, center.y, center.z}, 1, "m")
                            .array<double>("rotation", {rotation[0], rotation[1], rotation[2], rotation[3]})
                            .array<double>("velocity", {velocity.x, velocity.y, velocity.z}, 1, "m/s")
                            .array<double>("momentum", {momentum.x, momentum.y, momentum.z}, 1, "kg m²/s")
                            .status();
  return status ? write_tools(out, body, id) : status;
}

Status read_state(const SnapshotIn& in, RigidBody& body, BodyId id) {
  Reading reading(in.file, group_of(in.group, body));
  const auto vector = [&reading](const char* name) {
    const std::vector<double> n = reading.array<double>(name, 3);
    return n.size() == 3 ? Vec3d{n[0], n[1], n[2]} : Vec3d{};
  };
  // motion
  body.model.mass.center = vector("rest_center");
  body.state.center = vector("center"), body.state.velocity = vector("velocity");
  body.state.momentum = vector("momentum");
  const std::vector<double> q = reading.array<double>("rotation", 4);
  // surface
  const std::vector<float> x = reading.array<float>("rest", reading.count("rest", kMostRigidNumbers));
  const std::vector<int> t = reading.array<int>("triangles", reading.count("triangles", kMostRigidNumbers));
  if (!reading.status()) return reading.status();
  body.state.rotation = {q[0], q[1], q[2], q[3]};
  body.drawn = {};
  for (std::size_t n = 0; n + 2 < x.size(); n += 3) body.drawn.vertices.push_back({x[n], x[n + 1], x[n + 2]});
  for (std::size_t n = 0; n + 2 < t.size(); n += 3)
    body.drawn.triangles.push_back({t[n], t[n + 1], t[n + 2]});
  if (!all_indices(body.drawn.triangles, body.drawn.vertices.size()))
    reading.fail("triangles", "expected indices of its vertices");
  if (!reading.status()) return reading.status();
  // tools and snapshot
  BodySnapshot none;
  if (!body.tool_indices.empty())
    if (const Status tools = read_tools(in, body, none); !tools) return tools;
  show(in.exec, body, body_snapshot(in.snapshot, id));
  return Done{};
}

}  // namespace turgor
