// Old names of datasets in recordings. Readers accept them, so that recordings of earlier versions stay
// readable; writers use the current names only.
#pragma once

#include <string>
#include <string_view>

#include "turgor/io/files/hdf5_file.hpp"

namespace turgor {

struct RenamedDataset {
  const char *now, *before;  // last component of the path
};
constexpr RenamedDataset kRenamedDatasets[] = {
    {"virtual_nodes", "copies"},  // lattice bodies
    {"cut_edge_sub_index", "cut_edge_part"},
    {"positions", "places"},        // cloth
    {"tick_inputs", "ticks_knew"},  // haptic recordings
    {"frame_inputs", "frames_knew"},
    {"requests", "asks"},
};

/// Path under which a file holds the dataset: `path`, or the same with the old name if only that exists.
inline std::string stored_path(const Hdf5File& file, const std::string& path) {
  const std::size_t name_begin = path.rfind('/') + 1;
  for (const RenamedDataset& renamed : kRenamedDatasets) {
    if (std::string_view(path).substr(name_begin) != renamed.now || file.has(path)) continue;
    const std::string before = path.substr(0, name_begin) + renamed.before;
    if (file.has(before)) return before;
  }
  return path;
}

}  // namespace turgor
