// Folder of cached Green's functions: listing and size limit (green_cache.hpp).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>

#include <fmt/format.h>

#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/bodies/sfem/green_cache.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr double kDefaultLimit = 10;  // [GB]
constexpr double kMostLimit = 1e9;    // [GB]

bool is_our_name(const fs::path& file) {
  static const std::regex name("green-[0-9a-f]{16}\\.h5");
  return std::regex_match(file.filename().string(), name);
}

/// Symbolic links count as foreign files.
bool is_plain_file(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() == fs::file_type::regular;
}

/// False for foreign files.
bool read_entry(const fs::path& path, CacheFile& entry) {
  if (!is_our_name(path) || !is_plain_file(path)) return false;
  const Result<Hdf5File> file = Hdf5File::open(path);
  if (!file) return false;
  const Result<std::string> format = file->read_text("/format");
  if (!format || !format->starts_with("turgor Green's functions")) return false;
  if (file->has("/what_for"))
    if (const Result<std::string> what = file->read_text("/what_for")) entry.what_for = *what;
  std::error_code error;
  entry.file = path, entry.bytes = fs::file_size(path, error);
  if (!error) entry.used = fs::last_write_time(path, error);
  return !error;
}

}  // namespace

Result<CacheFolder> list_cache(const fs::path& folder) {
  CacheFolder found;
  std::error_code error;
  if (folder.empty() || !fs::exists(folder, error)) return found;
  fs::directory_iterator entries(folder, error);
  if (error)
    return Error{fmt::format("{}: expected a folder that can be read: {}", folder.string(), error.message())};
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    CacheFile entry;
    if (read_entry(entries->path(), entry))
      found.files.push_back(std::move(entry));
    else
      found.foreign.push_back(entries->path());
  }
  std::sort(found.files.begin(), found.files.end(), [](const CacheFile& a, const CacheFile& b) {
    return a.used != b.used ? a.used < b.used : a.file < b.file;
  });
  std::sort(found.foreign.begin(), found.foreign.end());
  return found;
}

Result<std::uintmax_t> cache_limit() {
  const char* text = std::getenv("TURGOR_CACHE_LIMIT");
  if (!text || !*text) return std::uintmax_t(kDefaultLimit * 1e9);
  char* end = nullptr;
  const double limit = std::strtod(text, &end);
  if (end == text || *end != 0 || !(limit >= 0 && limit <= kMostLimit))
    return Error{
        fmt::format("TURGOR_CACHE_LIMIT: expected GB from 0 to {:g}, found \"{}\"", kMostLimit, text)};
  return std::uintmax_t(limit * 1e9);
}

std::vector<CacheFile> trim_cache(const fs::path& folder, std::uintmax_t limit, const fs::path& keep) {
  std::vector<CacheFile> removed;
  // total size
  const Result<CacheFolder> found = list_cache(folder);
  if (!found) return removed;
  std::uintmax_t bytes = 0;
  for (const CacheFile& file : found->files) bytes += file.bytes;
  // remove files until the limit holds
  for (const CacheFile& file : found->files) {
    if (bytes <= limit) break;
    std::error_code error;
    if (file.file.filename() == keep.filename() || !fs::remove(file.file, error)) continue;
    bytes -= file.bytes;
    removed.push_back(file);
  }
  return removed;
}

std::vector<fs::path> remove_cache_leftovers(const fs::path& folder) {
  std::vector<fs::path> removed;
  std::error_code error;
  for (const fs::path& leftover : leftovers_in(folder)) {
    const std::string name = leftover.filename().string();
    const std::string target = name.substr(1, name.find(".partial-") - 1);
    if (is_our_name(target) && is_plain_file(leftover) && fs::remove(leftover, error))
      removed.push_back(leftover);
  }
  return removed;
}

}  // namespace turgor
