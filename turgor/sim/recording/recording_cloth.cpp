#include "turgor/sim/recording/recording_cloth.hpp"

#include <fmt/format.h>

#include "turgor/models/cloth/fields.hpp"
#include "turgor/sim/recording/recording_fields.hpp"

namespace turgor {

namespace {

/// In the numbering of the mesh.
RecordedEntries entries_of(const ClothBody& body) { return {Axis::kVertex, body.model.place}; }

std::string group_of(const std::string& snapshot, const ClothBody& body) {
  return fmt::format("{}/bodies/{}/", snapshot, body.name);
}

}  // namespace

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId) {
  Writing writing(out.file, group_of(out.group, body));
  write_fields(writing, body.state, entries_of(body));
  return writing.status();
}

Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id) {
  Reading reading(in.file, group_of(in.group, body));
  read_fields(reading, body.state, entries_of(body));
  if (reading.status()) show(in.exec, body, shown_body(in.shown, id));
  return reading.status();
}

}  // namespace turgor
