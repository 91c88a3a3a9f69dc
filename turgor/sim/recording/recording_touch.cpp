#include "turgor/sim/recording/recording_touch.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostVertices = std::size_t(1) << 24, kMostRows = kMostTicks + 1;
constexpr std::size_t kPose = 16;      // numbers per tool: position, axes, force, opening
constexpr std::size_t kSample = 27;    // numbers per tick, in the order of append
constexpr std::size_t kContacts = 10;  // the number of contacts among them
constexpr const char *kPoseUnits = "m, m, m, 1, 1, 1, 1, 1, 1, 1, 1, 1, N, N, N, m",
                     *kSampleUnits =
                         "s, m, m, m, N, N, N, N m, N m, N m, 1, m, m, s, 1, 1, 1, 1, 1, 1, 1, 1, "
                         "1, 1, 1, 1, 1";

std::vector<Vec3> vectors(const std::vector<float>& values) {
  TURGOR_CHECK(values.size() % 3 == 0, "a point has three numbers");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3)
    points.push_back({values[i], values[i + 1], values[i + 2]});
  return points;
}

void append(std::vector<double>& values, Vec3d v) { values.insert(values.end(), {v.x, v.y, v.z}); }
Vec3d vector_at(const std::vector<double>& values, std::size_t i) {
  TURGOR_CHECK(i + 2 < values.size(), "a vector has three numbers");
  return {values[i], values[i + 1], values[i + 2]};
}

std::vector<double> tool_rows(const std::vector<ToolSnapshot>& tools) {
  std::vector<double> values;
  for (const ToolSnapshot& tool : tools) {
    append(values, tool.pose.position);
    for (const Vec3d& axis : tool.pose.axes.column) append(values, axis);
    append(values, tool.force);
    values.push_back(tool.opening);
  }
  TURGOR_CHECK(values.size() == kPose * tools.size(), "every tool has kPose numbers");
  return values;
}

void show_row(const std::vector<double>& values, std::size_t row, const TouchingTool& tool,
              ToolSnapshot& out) {
  TURGOR_CHECK(values.size() >= kPose * (row + 1), "every tool has kPose numbers");
  const std::size_t i = kPose * row;
  const contact::Pose pose{vector_at(values, i),
                           {{vector_at(values, i + 3), vector_at(values, i + 6), vector_at(values, i + 9)}}};
  show_tool(tool, pose, vector_at(values, i + 12), values[i + 15], out);
}

void append(std::vector<double>& values, const ForceSample& s) {
  values.push_back(s.time);
  append(values, s.position);
  append(values, s.force);
  append(values, s.torque);
  values.insert(values.end(), {double(s.contacts), s.depth, s.path, s.tick_seconds, double(s.new_patch),
                               double(s.beyond_patch)});
  for (const Vec3d axis : s.axes.column) append(values, axis);
  values.insert(values.end(), {s.grip, double(s.hold)});
}

ForceSample sample_of(const std::vector<double>& values, std::size_t row) {
  TURGOR_CHECK(values.size() >= kSample * (row + 1), "every tick has kSample numbers");
  // fields in the order of append
  const std::size_t i = kSample * row;
  ForceSample s;
  s.time = values[i];
  s.position = vector_at(values, i + 1);
  s.force = vector_at(values, i + 4);
  s.torque = vector_at(values, i + 7);
  s.contacts = int(std::clamp(values[i + kContacts], 0.0, 1e6));
  s.depth = values[i + 11], s.path = values[i + 12], s.tick_seconds = float(values[i + 13]);
  s.new_patch = values[i + 14] != 0, s.beyond_patch = values[i + 15] != 0;
  for (std::size_t a = 0; a < 3; a++) s.axes.column[a] = vector_at(values, i + 16 + 3 * a);
  s.grip = values[i + 25], s.hold = values[i + 26] != 0;
  return s;
}

bool is_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

std::vector<std::int32_t> numbers_of(const std::vector<Int3>& triangles) {
  std::vector<std::int32_t> numbers;
  for (const Int3 t : triangles) numbers.insert(numbers.end(), {t.x, t.y, t.z});
  return numbers;
}

/// Empty if an index is not a vertex.
std::optional<std::vector<Int3>> triangles_of(const std::vector<std::int32_t>& numbers,
                                              std::size_t vertices) {
  std::vector<Int3> triangles;
  if (numbers.size() % 3 != 0) return {};
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    for (std::size_t k = i; k < i + 3; k++)
      if (numbers[k] < 0 || std::size_t(numbers[k]) >= vertices) return {};
    triangles.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  }
  return triangles;
}

/// Reads the surfaces of inclusions; false if they are damaged.
bool read_inside(Reading& reading, TriMesh& inside) {
  const std::size_t count = reading.count("inside", 3 * kMostVertices) / 3;
  const auto positions = reading.array<float>("inside", 3 * count);
  const std::size_t corners = reading.count("inside_triangles", 3 * 3 * kMostVertices);
  const auto triangles = triangles_of(reading.array<std::int32_t>("inside_triangles", corners), count);
  if (!triangles || !is_finite(positions)) return false;
  inside.vertices = vectors(positions), inside.triangles = *triangles;
  inside.normals = vertex_normals(inside);
  return true;
}

Status write_shown(Hdf5File& file, const std::string& group, double time, const BodySnapshot& surface,
                   const std::vector<ToolSnapshot>& tools) {
  TURGOR_CHECK(surface.displacement.size() == surface.rest.size(), "every vertex has a displacement");
  return Writing(file, group)
      .array<double>("time", {time}, 1, "s")
      .array("rest", flat(surface.rest), 3, "m")
      .array("displacement", flat(surface.displacement), 3, "m")
      .array("pressure", surface.pressure, 1, "Pa")
      .array("triangles", numbers_of(surface.triangles), 3)
      .array<std::int64_t>("wall_begin", {std::int64_t(surface.wall_begin)})
      .array<std::int64_t>("cap_count", {std::int64_t(surface.cap_count)})
      .array("coarse_triangles", numbers_of(surface.smooth.coarse), 3)
      .array("inside", flat(surface.inside.vertices), 3, "m")
      .array("inside_triangles", numbers_of(surface.inside.triangles), 3)
      .array<std::int32_t>("mesh_vertex", {surface.mesh_vertex.begin(), surface.mesh_vertex.end()})
      .array("tools", tool_rows(tools), kPose, kPoseUnits)
      .status();
}

/// Reads a number of triangles from 0 to `most`; `missing` if an older recording does not have it. False if
/// it is damaged.
bool read_triangle_count(Reading& reading, const Hdf5File& file, const std::string& group,
                         const std::string& name, std::size_t most, std::size_t missing, std::size_t& count) {
  count = missing;
  if (!file.has(group + name)) return true;
  const auto read = reading.array<std::int64_t>(name, 1);
  if (read.size() != 1) return true;  // the reading has the error
  count = std::size_t(std::clamp<std::int64_t>(read[0], 0, std::int64_t(most)));
  return read[0] == std::int64_t(count);
}

/// Reads the first triangle of wound walls and the number of caps. Older recordings do not tell them from
/// skin. False if one is damaged.
bool read_groups(Reading& reading, const Hdf5File& file, const std::string& group, BodySnapshot& surface) {
  const std::size_t all = surface.triangles.size();
  return read_triangle_count(reading, file, group, "wall_begin", all, all, surface.wall_begin) &&
         read_triangle_count(reading, file, group, "cap_count", surface.wall_begin, 0, surface.cap_count);
}

/// Content of a group besides the surface.
struct ReadRows {
  double time = 0;            // [s]
  std::vector<double> tools;  // kPose numbers per tool
};
Result<ReadRows> read_shown(const Hdf5File& file, const std::string& group, std::size_t tool_count,
                            BodySnapshot& surface) {
  Reading reading(file, group);
  const auto time = reading.array<double>("time", 1);
  const std::size_t count = reading.count("rest", 3 * kMostVertices) / 3,
                    known = reading.count("pressure", kMostVertices);
  surface.pressure = reading.array<float>("pressure", known);
  const auto rest = reading.array<float>("rest", 3 * count),
             displacement = reading.array<float>("displacement", 3 * count);
  const std::size_t corners = reading.count("triangles", 3 * 3 * kMostVertices);
  const auto triangles = reading.array<std::int32_t>("triangles", corners);
  const auto tools = reading.array<double>("tools", kPose * tool_count);
  const std::size_t numbers = reading.count("mesh_vertex", count);
  const auto mesh_vertex = reading.array<std::int32_t>("mesh_vertex", numbers);
  if (!reading.status()) return reading.status().error();
  const auto outer = triangles_of(triangles, count);
  const bool sound = read_inside(reading, surface.inside) && outer && (known == 0 || known == count) &&
                     (numbers == 0 || numbers == count) && is_finite(rest) && is_finite(displacement);
  if (!reading.status()) return reading.status().error();
  if (!sound) return Error{fmt::format("{}: {}: the surface is damaged", file.path().string(), group)};
  surface.mesh_vertex.assign(mesh_vertex.begin(), mesh_vertex.end());
  surface.rest = vectors(rest), surface.displacement = vectors(displacement);
  surface.triangles = *outer;
  if (!read_groups(reading, file, group, surface))
    return Error{fmt::format("{}: {}: the surface is damaged", file.path().string(), group)};
  if (!reading.status()) return reading.status().error();
  update_vertices(surface);
  // smooth surface; older recordings have none
  if (file.has(group + "coarse_triangles")) {
    const std::size_t coarse_corners = reading.count("coarse_triangles", 3 * 3 * kMostVertices);
    const auto coarse = triangles_of(reading.array<std::int32_t>("coarse_triangles", coarse_corners), count);
    if (!reading.status()) return reading.status().error();
    if (!coarse) return Error{fmt::format("{}: {}: the surface is damaged", file.path().string(), group)};
    set_coarse(*coarse, surface);
    show_smooth(surface);
  }
  return ReadRows{time[0], tools};
}

Status write_deepest(Hdf5File& file, const WorldSnapshot& snapshot, const Pressed& pressed) {
  const bool touched = pressed.force > 0;
  const BodySnapshot& body = touched ? pressed.body : body_snapshot(snapshot, pressed.id);
  const std::string group = fmt::format("/deepest/{}/", body.name);
  const Status status = write_shown(file, group, touched ? pressed.time : snapshot.time, body,
                                    touched ? pressed.tools : tools_on(snapshot, pressed.id));
  return status ? Writing(file, group).array<double>("force", {pressed.force}, 1, "N").status() : status;
}

Status read_deepest(const Hdf5File& file, const World& world, const TouchedBody& body, Pressed& pressed) {
  const std::string group = fmt::format("/deepest/{}/", body.name);
  const Result<ReadRows> rows = read_shown(file, group, body.tool_indices.size(), pressed.body);
  if (!rows) return rows.error();
  Reading reading(file, group);
  const auto force = reading.array<double>("force", 1);
  if (!reading.status()) return reading.status();
  pressed.time = rows->time, pressed.force = force[0];
  pressed.tools.resize(body.tool_indices.size());
  for (std::size_t t = 0; t < pressed.tools.size(); t++)
    show_row(rows->tools, t, world.tools[std::size_t(body.tool_indices[t])], pressed.tools[t]);
  return Done{};
}

std::string surface_group(const std::string& snapshot, const TouchedBody& body) {
  return fmt::format("{}/surfaces/{}/", snapshot, body.name);
}

/// Writes the drawn surface with its tools.
Status write_surface(const SnapshotOut& out, const TouchedBody& body, BodyId id) {
  return write_shown(out.file, surface_group(out.group, body), out.snapshot.time,
                     body_snapshot(out.snapshot, id), tools_on(out.snapshot, id));
}

/// True if the recording contains a surface with tools. Untouched lattices and cloth are drawn from their
/// states.
template <class Body>
bool keeps_surface(const Body& body) {
  constexpr bool has_state = std::is_same_v<Body, LatticeBody> || std::is_same_v<Body, ClothBody>;
  return !has_state || !body.tool_indices.empty();
}

}  // namespace

Status write_tools(const SnapshotOut& out, const TouchedBody& body, BodyId id) {
  if (body.tool_indices.empty()) return Done{};
  return write_shown(out.file, surface_group(out.group, body), out.snapshot.time, BodySnapshot(),
                     tools_on(out.snapshot, id));
}

Status read_tools(const SnapshotIn& in, const TouchedBody& body, BodySnapshot& surface) {
  const Result<ReadRows> rows =
      read_shown(in.file, surface_group(in.group, body), body.tool_indices.size(), surface);
  if (!rows) return rows.error();
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const auto n = std::size_t(body.tool_indices[t]);
    TURGOR_CHECK(is_index(n, in.snapshot.tools.size()), "a snapshot has every tool");
    show_row(rows->tools, t, in.world.tools[n], in.snapshot.tools[n]);
  }
  return Done{};
}

Status write_state(const SnapshotOut& out, const SfemBody& body, BodyId id) {
  return write_surface(out, body, id);
}
Status write_state(const SnapshotOut& out, const RhombusBody& body, BodyId id) {
  return write_surface(out, body, id);
}
Status read_state(const SnapshotIn& in, SfemBody& body, BodyId id) {
  return read_tools(in, body, body_snapshot(in.snapshot, id));
}
Status read_state(const SnapshotIn& in, RhombusBody& body, BodyId id) {
  return read_tools(in, body, body_snapshot(in.snapshot, id));
}

namespace {

/// Writes ticks in blocks: those of a long session are on disk and do not fit in memory.
Status write_ticks(Hdf5File& file, const TouchingTool& tool) {
  constexpr std::size_t kRowsAtOnce = 4096;
  const std::string name = fmt::format("/tools/{}/ticks", tool.name);
  std::vector<double> rows;
  append(rows, tool.samples.start());
  Status status = Done{};
  for (std::size_t n = 0; n < tool.samples.size() && status; n++) {
    append(rows, tool.samples[n]);
    if (rows.size() < kSample * kRowsAtOnce) continue;
    status = file.append<double>(name, rows, kSample);
    rows.clear();
  }
  if (status) status = file.append<double>(name, rows, kSample);
  return status ? file.write_attribute(name, "unit", kSampleUnits) : status;
}

}  // namespace

Status write_touch(Hdf5File& file, const World& world, const WorldSnapshot& snapshot,
                   const std::vector<Pressed>& pressed) {
  for (const TouchingTool& tool : world.tools) {
    if (const Status status = write_ticks(file, tool); !status) return status;
  }
  Status status = Done{};
  for_each_touched(world, [&](BodyId id, const auto& body) {
    if (status && keeps_surface(body)) status = write_deepest(file, snapshot, pressed_body(pressed, id));
  });
  return status;
}

Status read_touch(const Hdf5File& file, World& world, std::vector<Pressed>& pressed) {
  for (TouchingTool& tool : world.tools) {
    Reading reading(file, fmt::format("/tools/{}/", tool.name));
    const std::size_t count = reading.count("ticks", kSample * kMostRows);
    const auto rows = reading.array<double>("ticks", count);
    for (std::size_t r = 0; r < rows.size() / kSample; r++)
      if (!std::isfinite(rows[kSample * r + kContacts]))
        reading.fail("ticks", fmt::format("row {}: expected a number of contacts, found {}", r + 1,
                                          rows[kSample * r + kContacts]));
    if (!reading.status()) return reading.status();
    if (count >= kSample) tool.samples.start(command_of(sample_of(rows, 0)));
    for (std::size_t r = 1; r < count / kSample; r++) tool.samples.append(sample_of(rows, r));
  }
  pressed = make_pressed(world);
  Status status = Done{};
  std::size_t next = 0;
  for_each_touched(world, [&](BodyId id, const auto& body) {
    TURGOR_CHECK(next < pressed.size(), "every body that tools can touch is looked at");
    Pressed& one = pressed[next++];
    if (!status || !keeps_surface(body)) return;
    show_name(id, body, one.body);
    status = read_deepest(file, world, body, one);
  });
  return status;
}

}  // namespace turgor
