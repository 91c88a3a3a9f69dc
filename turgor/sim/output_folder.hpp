// Output folder of a run. Files are written into a hidden folder next to the goal and renamed only when
// complete: an interrupted run leaves earlier results intact. Of earlier results only files that turgor wrote
// are replaced (sim/output_manifest.hpp); foreign files are never removed without permission.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/unfinished.hpp"

namespace turgor {

/// Report with all numbers of a complete output.
constexpr const char* kReportFile = "report.json";

/// Treatment of files in the goal that turgor did not write, or that were changed since.
enum class Foreign { kRefuse, kRemove };

/// Parent folders that were created; empty ones are removed again.
struct MadeFolders {
  std::vector<std::filesystem::path> paths;  // inner ones first

  MadeFolders() = default;
  MadeFolders(MadeFolders&&) = default;
  MadeFolders& operator=(MadeFolders&&) = default;
  ~MadeFolders();
};

class OutputFolder {
 public:
  /// Error: the goal is a file, a folder of other content, or has foreign files; the message names them.
  static Result<OutputFolder> create(const std::filesystem::path& goal, Foreign foreign = Foreign::kRefuse);

  /// Folder to write into.
  const std::filesystem::path& path() const { return partial_.path(); }
  const std::filesystem::path& goal() const { return goal_; }
  /// Foreign files that commit removes, relative to the goal.
  const std::vector<std::string>& removed_foreign() const { return removed_foreign_; }
  /// Error: the file is part of earlier results, which commit replaces.
  Status check_input(const std::filesystem::path& file) const;
  /// Renames the folder to the goal, replacing an earlier run. On failure the results stay under another
  /// name, which the error states.
  Status commit();
  /// After commit: folder of foreign files that were added during the run; empty if there were none.
  const std::filesystem::path& kept() const { return kept_; }

 private:
  OutputFolder(std::filesystem::path goal, MadeFolders made, std::vector<std::string> removed_foreign);
  Status replace_goal();

  std::filesystem::path goal_, kept_;
  std::vector<std::string> removed_foreign_;
  MadeFolders made_;
  Unfinished partial_;
};

/// Notes about foreign files in the goal: those that commit will remove, and the location of files added
/// during the run. Empty if there are none.
std::string removed_foreign_note(const OutputFolder& folder);
std::string kept_note(const OutputFolder& folder);

}  // namespace turgor
