#include "turgor/sim/output_manifest.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Size [bytes] and modification time [ns].
using Stamp = std::pair<std::int64_t, std::int64_t>;
using Stamps = std::map<std::string, Stamp>;

Stamp stamp_of(const fs::path& file) {
  struct stat now {};
  if (lstat(file.c_str(), &now) != 0) return {-1, -1};
  return {now.st_size, std::int64_t(now.st_mtim.tv_sec) * 1000000000 + now.st_mtim.tv_nsec};
}

/// All files of a folder except the manifest, by relative name.
Result<Stamps> files_in(const fs::path& folder) {
  Stamps files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().lexically_relative(folder).string();
    if (name == kManifestFile || fs::is_directory(entry->symlink_status())) continue;
    files[name] = stamp_of(entry->path());
  }
  if (error) return Error{fmt::format("{}: cannot be read: {}", folder.string(), error.message())};
  return files;
}

Result<Stamps> read_manifest(const fs::path& folder) {
  // text
  const Error none{fmt::format("it has no {}", kManifestFile)};
  const Error damaged{fmt::format("its {} is damaged", kManifestFile)};
  std::error_code ignored;
  if (!fs::is_regular_file(fs::symlink_status(folder / kManifestFile, ignored))) return none;
  const Result<std::string> text = read_file(folder / kManifestFile);
  if (!text) return damaged;

  // JSON
  const nlohmann::json json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("files") || !json["files"].is_object()) return damaged;
  Stamps files;
  for (const auto& [name, stamp] : json["files"].items()) {
    const bool sound =
        stamp.is_array() && stamp.size() == 2 && stamp[0].is_number_integer() && stamp[1].is_number_integer();
    if (!sound) return damaged;
    files[name] = {stamp[0].get<std::int64_t>(), stamp[1].get<std::int64_t>()};
  }
  return files;
}

/// Removes empty folders recursively.
void remove_empty_folders(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (fs::is_directory(entry.symlink_status(ignored))) remove_empty_folders(entry.path());
  fs::remove(folder, ignored);
}

}  // namespace

Status write_manifest(const fs::path& folder) {
  const Result<Stamps> files = files_in(folder);
  if (!files) return files.error();
  nlohmann::json json{
      {"what", "files written by turgor: size [bytes], modification time [ns]; only these are replaced"},
      {"files", nlohmann::json::object()}};
  for (const auto& [name, stamp] : *files) json["files"][name] = stamp;
  return write_file(folder / kManifestFile,
                    json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

Result<std::vector<std::string>> foreign_files(const fs::path& folder) {
  const Result<Stamps> ours = read_manifest(folder);
  if (!ours) return ours.error();
  const Result<Stamps> files = files_in(folder);
  if (!files) return files.error();
  std::vector<std::string> foreign;
  for (const auto& [name, stamp] : *files)
    if (const auto found = ours->find(name); found == ours->end() || found->second != stamp)
      foreign.push_back(name);
  return foreign;
}

bool remove_ours(const fs::path& folder, const std::vector<std::string>& also) {
  std::error_code ignored;

  // lists
  const Result<std::vector<std::string>> foreign = foreign_files(folder);
  if (!foreign) return false;
  const Result<Stamps> files = files_in(folder);
  if (!files) return false;

  // files, then empty folders
  bool empty = true;
  for (const auto& [name, stamp] : *files) {
    const bool is_kept = std::binary_search(foreign->begin(), foreign->end(), name) &&
                         std::find(also.begin(), also.end(), name) == also.end();
    if (is_kept || !fs::remove(folder / name, ignored)) empty = false;
  }
  if (empty) fs::remove(folder / kManifestFile, ignored);
  remove_empty_folders(folder);
  return !fs::exists(folder, ignored);
}

}  // namespace turgor
