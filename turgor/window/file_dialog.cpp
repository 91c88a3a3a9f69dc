#include "turgor/window/file_dialog.hpp"

#include <algorithm>
#include <array>
#include <system_error>

namespace turgor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostEntries = 5000;
constexpr std::array<std::string_view, 2> kEndings{".toml", ".mrk.json"};

bool has_ending(const std::string& name, std::span<const std::string_view> endings) {
  return std::any_of(endings.begin(), endings.end(),
                     [&name](std::string_view ending) { return name.ends_with(ending); });
}

}  // namespace

FolderList list_folder(const fs::path& folder, std::span<const std::string_view> endings) {
  FolderList list;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    if (list.entries.size() == kMostEntries) break;
    std::error_code ignored;
    FolderEntry entry{at->path().filename().string(), at->is_directory(ignored)};
    if (entry.name.starts_with('.') || !(entry.is_folder || has_ending(entry.name, endings))) continue;
    list.entries.push_back(std::move(entry));
  }
  if (failed) list.problem = folder.string() + ": " + failed.message();
  std::sort(list.entries.begin(), list.entries.end(), [](const FolderEntry& a, const FolderEntry& b) {
    return a.is_folder != b.is_folder ? a.is_folder : a.name < b.name;
  });
  return list;
}

void open_dialog(FileDialog::Purpose purpose, const fs::path& folder, const std::string& name,
                 FileDialog& dialog) {
  dialog.purpose = purpose, dialog.is_open = true;
  std::error_code ignored;
  enter_folder(folder.empty() ? fs::current_path(ignored) : folder, dialog);
  dialog.name = name;
}

void enter_folder(const fs::path& folder, FileDialog& dialog) {
  std::error_code ignored;
  dialog.folder = fs::absolute(folder, ignored).lexically_normal();
  dialog.list = list_folder(dialog.folder, kEndings);
  if (dialog.purpose == FileDialog::Purpose::kOpen) dialog.name.clear();
}

std::optional<fs::path> confirm(FileDialog& dialog) {
  if (dialog.name.empty()) return std::nullopt;
  fs::path file = dialog.folder / dialog.name;  // an absolute name replaces the folder
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    enter_folder(file, dialog);
    return std::nullopt;
  }
  if (dialog.purpose == FileDialog::Purpose::kSave && file.extension() != ".toml") file += ".toml";
  dialog.is_open = false;
  return file;
}

}  // namespace turgor
