#include "turgor/sim/recording/recording_cloth.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/model/fields.hpp"
#include "turgor/sim/recording/recording_fields.hpp"
#include "turgor/sim/recording/recording_touch.hpp"

namespace turgor {

namespace {

/// Entries in the vertex order of the mesh.
RecordedEntries entries_of(const ClothBody& body) {
  TURGOR_CHECK(all_indices(body.model.model_vertex, std::size_t(body.model.count)),
               "every vertex of the mesh is a vertex of the model");
  return {Axis::kVertex, body.model.model_vertex};
}

std::string group_of(const std::string& snapshot, const ClothBody& body) {
  return fmt::format("{}/bodies/{}/", snapshot, body.name);
}

std::string group_of(const ClothBody& body) { return fmt::format("/bodies/{}/", body.name); }

/// Rest positions in the vertex order of the mesh [m].
std::vector<Vec3> rest_of(const ClothBody& body) {
  std::vector<Vec3> rest;
  for (const int v : entries_of(body).listed) rest.push_back(body.model.x_rest[std::size_t(v)]);
  return rest;
}

std::vector<std::int32_t> corners_of(const ClothBody& body) {
  std::vector<std::int32_t> corners;
  for (const Int3 t : body.triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
  return corners;
}

Error other_mesh(const Hdf5File& file, const ClothBody& body, const std::string& difference) {
  return {fmt::format("{}: body.{} has another mesh than in the recorded run: {}", file.path().string(),
                      body.name, difference)};
}

std::string vertex_text(Vec3 x) { return fmt::format("{:.6g}, {:.6g}, {:.6g} m", x.x, x.y, x.z); }

/// First vertex with another rest position. Another processor may round positions differently.
std::string rest_difference(const std::vector<float>& recorded, const std::vector<Vec3>& rest) {
  constexpr float kRounding = 1e-6f;  // of the largest coordinate
  float largest = 0;
  for (const float x : recorded) largest = std::max(largest, std::abs(x));
  for (std::size_t v = 0; v < rest.size(); v++) {
    const Vec3 expected{recorded[3 * v], recorded[3 * v + 1], recorded[3 * v + 2]};
    if (!(norm(rest[v] - expected) <= kRounding * largest))
      return fmt::format("expected vertex {} at {}, found {}", v, vertex_text(expected),
                         vertex_text(rest[v]));
  }
  return {};
}

}  // namespace

Status write_body(Hdf5File& file, const ClothBody& body) {
  return Writing(file, group_of(body))
      .array("rest", flat(rest_of(body)), 3, "m")
      .array("triangles", corners_of(body), 3)
      .status();
}

Status check_body(const Hdf5File& file, const ClothBody& body) {
  constexpr std::size_t kMost = std::size_t(1) << 28;  // numbers
  if (!file.has(group_of(body) + "rest")) return Done{};
  const std::vector<Vec3> rest = rest_of(body);
  const std::vector<std::int32_t> corners = corners_of(body);

  // sizes
  Reading reading(file, group_of(body));
  const std::size_t numbers = reading.count("rest", kMost), indices = reading.count("triangles", kMost);
  if (!reading.status()) return reading.status();
  if (numbers != 3 * rest.size() || indices != corners.size())
    return other_mesh(file, body,
                      fmt::format("expected {} vertices and {} triangles, found {} and {}", numbers / 3,
                                  indices / 3, rest.size(), corners.size() / 3));

  // positions and triangles
  const auto recorded = reading.array<float>("rest", numbers);
  const auto triangles = reading.array<std::int32_t>("triangles", indices);
  if (!reading.status()) return reading.status();
  if (const std::string difference = rest_difference(recorded, rest); !difference.empty())
    return other_mesh(file, body, difference);
  const auto other = std::mismatch(triangles.begin(), triangles.end(), corners.begin());
  if (other.first == triangles.end()) return Done{};
  return other_mesh(file, body,
                    fmt::format("triangle {} has other vertices", (other.first - triangles.begin()) / 3));
}

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId id) {
  Writing writing(out.file, group_of(out.group, body));
  write_fields(writing, *body.state, entries_of(body));
  return writing.status() ? write_tools(out, body, id) : writing.status();
}

Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id) {
  Reading reading(in.file, group_of(in.group, body));
  read_fields(reading, body.state.change(), entries_of(body));
  if (!reading.status()) return reading.status();
  BodySnapshot none;
  if (!body.tool_indices.empty())
    if (const Status tools = read_tools(in, body, none); !tools) return tools;
  show(in.exec, body, body_snapshot(in.snapshot, id));
  return Done{};
}

}  // namespace turgor
