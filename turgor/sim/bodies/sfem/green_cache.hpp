// Green's functions kept between runs: an HDF5 file whose name and content carry the hash of exactly what
// they depend on (mesh, materials, fixed vertices, kept vertices, formulation, precision). What is read is
// checked before it is used; a file that is damaged, cut short or of something else is named and never used.
// A folder holds no more than its limit: what was not used for longest goes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

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

/// Written beside and renamed. `what_for`: what a listing says of it, such as the body's place in its scene.
Status write_green(const std::filesystem::path& file, const sfem::Model& model,
                   const std::string& what_for = "");

/// The user's cache folder, see green_cache_file. Empty when there is none.
std::filesystem::path user_cache_folder();

/// A file of Green's functions, by its name and by what is in it.
struct CacheFile {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  std::filesystem::file_time_type used;  // last read or written
  std::string what_for;                  // empty = not said
};
struct CacheFolder {
  std::vector<CacheFile> files;  // longest unused first
  std::vector<std::filesystem::path>
      foreign;  // all else: damaged, links, folders, of other programs; left alone
};
/// A folder that is not there is empty. Error: it cannot be read.
Result<CacheFolder> list_cache(const std::filesystem::path& folder);

/// Of all files in a folder [bytes]: $TURGOR_CACHE_LIMIT in GB, else 10. Error: it is no number of GB.
Result<std::uintmax_t> cache_limit();

/// Removes what was not used for longest until the rest is within the limit, but never `keep`. Returns what
/// was removed; a file that cannot be is left.
std::vector<CacheFile> trim_cache(const std::filesystem::path& folder, std::uintmax_t limit,
                                  const std::filesystem::path& keep = {});

}  // namespace turgor
