// The folder a run leaves behind. Everything is written into a hidden folder beside the goal,
// ".NAME.partial-PID", which takes the goal's name only when it is complete: an interrupted or killed run
// leaves earlier results whole. Folders of killed runs are removed by the next one.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"

namespace turgor {

/// The file that marks a folder as a complete output of ours, which may be replaced.
constexpr const char* kReportFile = "report.json";

class OutputFolder {
 public:
  /// Error: the goal is a file, or a folder with something else inside than an earlier run's output.
  static Result<OutputFolder> create(const std::filesystem::path& goal);
  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  /// Removes what was not committed.
  ~OutputFolder();

  /// Where to write.
  const std::filesystem::path& path() const { return partial_; }
  const std::filesystem::path& goal() const { return goal_; }
  /// Gives the folder its name, in place of an earlier run's.
  Status commit();

 private:
  OutputFolder(std::filesystem::path goal, std::filesystem::path partial);

  std::filesystem::path goal_, partial_;
};

/// From now on SIGINT and SIGTERM remove the folders that are not committed and end the program with code
/// 130. Call before other threads start: they inherit that these signals are somebody else's.
void remove_partial_folders_when_interrupted();

}  // namespace turgor
