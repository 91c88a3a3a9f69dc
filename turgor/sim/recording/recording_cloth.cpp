#include "turgor/sim/recording/recording_cloth.hpp"

#include "turgor/models/cloth/fields.hpp"
#include "turgor/sim/recording/recording_fields.hpp"

namespace turgor {

namespace {

/// In the numbering of the mesh.
RecordedEntries entries_of(const ClothBody& body) { return {Axis::kVertex, body.model.place}; }

}  // namespace

Status write_cloth(Hdf5File& file, const std::string& group, const ClothBody& body) {
  Writing writing(file, group);
  write_fields(writing, body.state, entries_of(body));
  return writing.status();
}

Status read_cloth(const Hdf5File& file, const std::string& group, ClothBody& body) {
  Reading reading(file, group);
  read_fields(reading, body.state, entries_of(body));
  return reading.status();
}

}  // namespace turgor
