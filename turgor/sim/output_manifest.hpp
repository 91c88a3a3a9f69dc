// What a run wrote, listed in a file of its folder. Only what is listed, and still is as it was written (size
// and time of the last change: an edit changes them, and no file has to be read again), is ours to remove. A
// folder without such a list is not ours.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// The file that holds the list, and so marks a folder as a complete output of ours.
constexpr const char* kManifestFile = ".turgor-output";

/// Lists all files of a folder.
Status write_manifest(const std::filesystem::path& folder);

/// Files in a folder of ours, relative to it and sorted, that we did not write or that were changed since.
/// Error: it is not ours.
Result<std::vector<std::string>> foreign_files(const std::filesystem::path& folder);

/// Removes what is ours, and of the rest what is named. False when something is left, the folder with it.
bool remove_ours(const std::filesystem::path& folder, const std::vector<std::string>& also);

}  // namespace turgor
