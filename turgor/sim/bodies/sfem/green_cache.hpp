// Cache of Green's functions between runs: HDF5 files whose name and content include the hash of all inputs
// (mesh, materials, fixed vertices, kept vertices, formulation, precision). Data are verified before use;
// damaged or foreign files are reported and not used. Each folder has a size limit; the least recently used
// files are removed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/scene_cache.hpp"

namespace turgor {

/// File for a content hash in this folder, or if it is empty in the user's cache folder
/// ($XDG_CACHE_HOME/turgor, else ~/.cache/turgor). Empty if there is no such folder.
std::filesystem::path green_cache_file(const std::filesystem::path& folder, std::uint64_t content_hash);

struct CachedGreen {
  bool found = false;  // true if the model has its Green's functions
  std::string note;    // why an existing file was not used: a sentence
  bool keep = false;   // the file may be sound and could not be checked: it is not replaced
};
/// Fills Model::green from the file. A missing file gives no note.
CachedGreen read_green(const std::filesystem::path& file, sfem::Model& model);

/// Writes a temporary file and renames it. `what_for`: description in listings, such as the source location
/// of the body.
Status write_green(const std::filesystem::path& file, const sfem::Model& model,
                   const std::string& what_for = "");

/// Metadata of a cached file.
struct CacheFile {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  std::filesystem::file_time_type used;  // last read or write
  std::string what_for;                  // empty = unknown
};
struct CacheFolder {
  std::vector<CacheFile> files;  // least recently used first
  std::vector<std::filesystem::path>
      foreign;  // other files, which are left alone: damaged ones, links, folders, files of other programs
};
/// Lists a folder; a missing folder is empty. Error: not readable.
Result<CacheFolder> list_cache(const std::filesystem::path& folder);

/// Limit of a folder [bytes]: $TURGOR_CACHE_LIMIT in GB, else 10. Error: not a number of GB.
Result<std::uintmax_t> cache_limit();

/// Removes least recently used files until the rest is within the limit, never `keep`. Returns the removed
/// files; files that cannot be removed are skipped.
std::vector<CacheFile> trim_cache(const std::filesystem::path& folder, std::uintmax_t limit,
                                  const std::filesystem::path& keep = {});

/// Removes unfinished files of killed programs; returns the removed ones.
std::vector<std::filesystem::path> remove_cache_leftovers(const std::filesystem::path& folder);

}  // namespace turgor
