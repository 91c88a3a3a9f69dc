// Reading and writing of whole files. A file appears under its name only when it is complete: it is written
// to a temporary file beside it and renamed. Every step is checked for errors, including close.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"
#include "turgor/io/files/unfinished.hpp"

namespace turgor {

/// A file that is written block by block. Without commit an existing file stays unchanged.
class FileWriter {
 public:
  /// Follows links. Pipes and devices are written directly.
  static Result<FileWriter> create(const std::filesystem::path& path);
  FileWriter(FileWriter&& other) noexcept;
  FileWriter& operator=(FileWriter&&) = delete;
  ~FileWriter();

  /// After the first failure nothing more is written; commit returns the error.
  void write(std::string_view bytes);
  Status commit();

 private:
  FileWriter(std::filesystem::path path, std::filesystem::path goal)
      : path_(std::move(path)), goal_(std::move(goal)) {}
  Error error(int number) const;

  std::filesystem::path path_, goal_;  // as given, and with links resolved
  std::optional<Unfinished> partial_;  // empty: written directly into a pipe or a device
  int descriptor_ = -1;
  int failure_ = 0;  // errno of the first failure
};

/// Checks that a file can be written to this path, before the work that computes it. Error: the folder does
/// not exist, the path is a folder, or the file is write-protected.
Status check_file_goal(const std::filesystem::path& path);

Status write_file(const std::filesystem::path& path, std::string_view bytes);
Result<std::string> read_file(const std::filesystem::path& path);

}  // namespace turgor
