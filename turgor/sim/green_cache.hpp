// Green's functions kept between runs: an HDF5 file whose name and content carry the hash of exactly what
// they depend on (mesh, materials, fixed vertices, kept vertices, formulation, precision). What is read is
// checked before it is used; a file that is damaged, cut short or of something else is named and never used.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor {

/// The file for a content hash, in this folder or, when that is empty, in the user's cache folder
/// ($XDG_CACHE_HOME/turgor, else ~/.cache/turgor). Empty when there is no such folder.
std::filesystem::path green_cache_file(const std::filesystem::path& folder, std::uint64_t content_hash);

struct CachedGreen {
  bool found = false;  // the model has its Green's functions now
  std::string note;    // why a file that is there was not used: a sentence
};
/// Fills Model::green from the file. A file that is not there is no reason for a note.
CachedGreen read_green(const std::filesystem::path& file, sfem::Model& model);

/// Written beside and renamed.
Status write_green(const std::filesystem::path& file, const sfem::Model& model);

}  // namespace turgor
