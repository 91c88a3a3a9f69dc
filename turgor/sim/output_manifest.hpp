// Manifest of the files that a run wrote, stored in its folder. Only listed files with unchanged size and
// modification time count as ours and may be removed; no file is read again. A folder without manifest is not
// ours.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// The manifest; it marks a folder as a complete output.
constexpr const char* kManifestFile = ".turgor-output";

/// Lists all files of a folder.
Status write_manifest(const std::filesystem::path& folder);

/// Foreign files in one of our folders, sorted relative paths: not written by us, or changed since. Error:
/// the folder is not ours.
Result<std::vector<std::string>> foreign_files(const std::filesystem::path& folder);

/// Removes our files, and foreign ones that are listed. False if files remain, and the folder with them.
bool remove_ours(const std::filesystem::path& folder, const std::vector<std::string>& also);

}  // namespace turgor
