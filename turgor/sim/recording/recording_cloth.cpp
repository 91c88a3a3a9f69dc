#include "turgor/sim/recording/recording_cloth.hpp"

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

}  // namespace

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
