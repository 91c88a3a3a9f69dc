#include "turgor/sim/recording/recording_touch.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/recording/recording_arrays.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostVertices = std::size_t(1) << 24, kMostTicks = std::size_t(1) << 22;
constexpr std::size_t kPose = 16;  // numbers of a shown tool: position, axes, force, opening
constexpr const char *kPoseUnits = "m, m, m, 1, 1, 1, 1, 1, 1, 1, 1, 1, N, N, N, m",
                     *kSampleUnits = "s, m, m, m, N, N, N, N m, N m, N m, 1, m, m, s, 1, 1";
constexpr std::size_t kSample = 16;  // numbers of a tick, in the order of sample_row

std::vector<float> flat(const std::vector<Vec3>& points) {
  std::vector<float> values;
  for (const Vec3 p : points) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

std::vector<Vec3> vectors(const std::vector<float>& values) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3)
    points.push_back({values[i], values[i + 1], values[i + 2]});
  return points;
}

void append(std::vector<double>& values, Vec3d v) { values.insert(values.end(), {v.x, v.y, v.z}); }
Vec3d vector_at(const std::vector<double>& values, std::size_t i) {
  return {values[i], values[i + 1], values[i + 2]};
}

std::vector<double> tool_rows(const std::vector<ShownTool>& tools) {
  std::vector<double> values;
  for (const ShownTool& tool : tools) {
    append(values, tool.pose.position);
    for (const Vec3d& axis : tool.pose.axes.column) append(values, axis);
    append(values, tool.force);
    values.push_back(tool.opening);
  }
  return values;
}

ShownTool tool_of(const std::vector<double>& values, std::size_t row) {
  const std::size_t i = kPose * row;
  return {{vector_at(values, i),
           {{vector_at(values, i + 3), vector_at(values, i + 6), vector_at(values, i + 9)}}},
          vector_at(values, i + 12),
          values[i + 15]};
}

void append(std::vector<double>& values, const ForceSample& s) {
  values.push_back(s.time);
  append(values, s.position);
  append(values, s.force);
  append(values, s.torque);
  values.insert(values.end(), {double(s.contacts), s.depth, s.path, s.tick_seconds, double(s.new_patch),
                               double(s.beyond_patch)});
}

ForceSample sample_of(const std::vector<double>& values, std::size_t row) {
  const std::size_t i = kSample * row;
  ForceSample s;
  s.time = values[i];
  s.position = vector_at(values, i + 1);
  s.force = vector_at(values, i + 4);
  s.torque = vector_at(values, i + 7);
  s.contacts = int(std::clamp(values[i + 10], 0.0, 1e6));
  s.depth = values[i + 11], s.path = values[i + 12], s.tick_seconds = float(values[i + 13]);
  s.new_patch = values[i + 14] != 0, s.beyond_patch = values[i + 15] != 0;
  return s;
}

bool is_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

Status write_shown(Hdf5File& file, const std::string& group, const ShownSurface& surface) {
  std::vector<std::int32_t> triangles;
  for (const Int3 t : surface.triangles) triangles.insert(triangles.end(), {t.x, t.y, t.z});
  return Writing(file, group)
      .array<double>("time", {surface.time}, 1, "s")
      .array("rest", flat(surface.rest), 3, "m")
      .array("displacement", flat(surface.displacement), 3, "m")
      .array("pressure", surface.pressure, 1, "Pa")
      .array("triangles", triangles, 3)
      .array<std::int32_t>("mesh_vertex", {surface.mesh_vertex.begin(), surface.mesh_vertex.end()})
      .array("tools", tool_rows(surface.tools), kPose, kPoseUnits)
      .status();
}

Result<ShownSurface> read_shown(const Hdf5File& file, const std::string& group, std::size_t tool_count) {
  Reading reading(file, group);
  ShownSurface surface;
  const auto time = reading.array<double>("time", 1);
  const std::size_t count = reading.count("pressure", kMostVertices);
  surface.pressure = reading.array<float>("pressure", count);
  const auto rest = reading.array<float>("rest", 3 * count),
             displacement = reading.array<float>("displacement", 3 * count);
  const std::size_t corners = reading.count("triangles", 3 * 3 * kMostVertices);
  const auto triangles = reading.array<std::int32_t>("triangles", corners);
  const auto tools = reading.array<double>("tools", kPose * tool_count);
  // Files of earlier versions do not have it.
  const std::size_t numbers = reading.has("mesh_vertex") ? reading.count("mesh_vertex", count) : 0;
  std::vector<std::int32_t> mesh_vertex;
  if (numbers > 0) mesh_vertex = reading.array<std::int32_t>("mesh_vertex", count);
  if (!reading.status()) return reading.status().error();
  const bool sound = std::all_of(triangles.begin(), triangles.end(),
                                 [count](int v) { return v >= 0 && std::size_t(v) < count; }) &&
                     corners % 3 == 0 && is_finite(rest) && is_finite(displacement);
  if (!sound) return Error{fmt::format("{}: the surface is damaged", group)};
  surface.time = time[0];
  surface.mesh_vertex.assign(mesh_vertex.begin(), mesh_vertex.end());
  surface.rest = vectors(rest), surface.displacement = vectors(displacement);
  for (std::size_t i = 0; i < corners; i += 3)
    surface.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
  for (std::size_t t = 0; t < tool_count; t++) surface.tools.push_back(tool_of(tools, t));
  return surface;
}

/// For every body whose surface is kept.
template <class AnyWorld, class Do>
Status for_kept_surfaces(AnyWorld& world, const Do& act) {
  return try_each_touched(world, [&](BodyId id, auto& body) -> Status {
    return keeps_surface(id, body) ? act(body) : Status(Done{});
  });
}

Status write_deepest(Hdf5File& file, const TouchedBody& body) {
  const std::string group = fmt::format("/deepest/{}/", body.name);
  const Status status = write_shown(file, group, body.largest_force > 0 ? body.deepest : body.shown);
  return status ? Writing(file, group).array<double>("force", {body.largest_force}, 1, "N").status() : status;
}

Status read_deepest(const Hdf5File& file, TouchedBody& body) {
  const std::string group = fmt::format("/deepest/{}/", body.name);
  Result<ShownSurface> deepest = read_shown(file, group, body.tool_indices.size());
  if (!deepest) return deepest.error();
  Reading reading(file, group);
  const auto force = reading.array<double>("force", 1);
  if (!reading.status()) return reading.status();
  body.deepest = std::move(*deepest), body.largest_force = force[0];
  return Done{};
}

std::string surface_group(const std::string& snapshot, const TouchedBody& body) {
  return fmt::format("{}/surfaces/{}/", snapshot, body.name);
}

}  // namespace

Status write_surfaces(Hdf5File& file, const std::string& snapshot, const World& world) {
  return for_kept_surfaces(world, [&](const TouchedBody& body) {
    return write_shown(file, surface_group(snapshot, body), body.shown);
  });
}

Status read_surfaces(const Hdf5File& file, const std::string& snapshot, World& world) {
  return for_kept_surfaces(world, [&](TouchedBody& body) -> Status {
    Result<ShownSurface> surface = read_shown(file, surface_group(snapshot, body), body.tool_indices.size());
    if (!surface) return surface.error();
    body.shown = std::move(*surface);
    return Done{};
  });
}

Status write_touch(Hdf5File& file, const World& world) {
  for (const TouchingTool& tool : world.tools) {
    std::vector<double> rows;
    for (const ForceSample& sample : tool.samples) append(rows, sample);
    const Status status = Writing(file, fmt::format("/tools/{}/", tool.name))
                              .array("ticks", rows, kSample, kSampleUnits)
                              .status();
    if (!status) return status;
  }
  return for_kept_surfaces(world, [&](const TouchedBody& body) { return write_deepest(file, body); });
}

Status read_touch(const Hdf5File& file, World& world) {
  for (TouchingTool& tool : world.tools) {
    Reading reading(file, fmt::format("/tools/{}/", tool.name));
    const std::size_t count = reading.count("ticks", kSample * kMostTicks);
    const auto rows = reading.array<double>("ticks", count);
    if (!reading.status()) return reading.status();
    for (std::size_t r = 0; r < count / kSample; r++) tool.samples.push_back(sample_of(rows, r));
  }
  return for_kept_surfaces(world, [&](TouchedBody& body) { return read_deepest(file, body); });
}

}  // namespace turgor
