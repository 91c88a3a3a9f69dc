// Whole files in and out. A file appears under its name only when it is complete: it is written beside it and
// renamed. Everything that can fail is checked, closing included.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"
#include "turgor/io/files/unfinished.hpp"

namespace turgor {

/// A file written piece by piece. Without commit an earlier one stays as it was.
class FileWriter {
 public:
  /// Links are followed; what is no file (a pipe, a device) is written straight into.
  static Result<FileWriter> create(const std::filesystem::path& path);
  FileWriter(FileWriter&& other) noexcept;
  FileWriter& operator=(FileWriter&&) = delete;
  ~FileWriter();

  /// After the first failure nothing more is written; commit tells it.
  void write(std::string_view bytes);
  Status commit();

 private:
  FileWriter(std::filesystem::path path, std::filesystem::path goal)
      : path_(std::move(path)), goal_(std::move(goal)) {}
  Error error(int number) const;

  std::filesystem::path path_, goal_;  // as given, and with links followed
  std::optional<Unfinished> partial_;  // none: straight into a pipe or a device
  int descriptor_ = -1;
  int failure_ = 0;  // errno of the first failure
};

/// Whether a file may be written here: known before the work that fills it. Error: no such folder, a folder,
/// a write-protected file.
Status check_file_goal(const std::filesystem::path& path);

Status write_file(const std::filesystem::path& path, std::string_view bytes);
Result<std::string> read_file(const std::filesystem::path& path);

}  // namespace turgor
