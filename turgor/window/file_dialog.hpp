// A file dialog inside the window. It lists a folder; Dear ImGui draws it (panel_files.cpp).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace turgor {

/// Entry of a folder.
struct FolderEntry {
  std::string name;
  bool is_folder = false;
};

/// Content of a folder: folders first, then the files with one of these endings, each sorted by name. Hidden
/// entries are left out. `problem`: reason why the folder cannot be read, or empty.
struct FolderList {
  std::vector<FolderEntry> entries;
  std::string problem;
};
FolderList list_folder(const std::filesystem::path& folder, std::span<const std::string_view> endings);

/// A dialog that is open, or the folder and name of the last one.
struct FileDialog {
  enum class Purpose : std::uint8_t { kOpen, kSave };
  Purpose purpose = Purpose::kOpen;
  bool is_open = false;
  std::filesystem::path folder;
  std::string name;  // chosen or typed
  FolderList list;
};

/// Opens the dialog in a folder; an empty one is the current folder.
void open_dialog(FileDialog::Purpose purpose, const std::filesystem::path& folder, const std::string& name,
                 FileDialog& dialog);
/// Shows another folder.
void enter_folder(const std::filesystem::path& folder, FileDialog& dialog);
/// Confirms the name: enters a folder, or closes the dialog and returns the file. A saved file gets the
/// ending .toml if it has none. Empty while there is no name.
std::optional<std::filesystem::path> confirm(FileDialog& dialog);

}  // namespace turgor
