// The folder a run leaves behind. Everything is written into a hidden folder beside the goal, which takes the
// goal's name only when it is complete: an interrupted or killed run leaves earlier results whole. Of earlier
// results only what turgor wrote is replaced (sim/output_manifest.hpp); nothing that others put there is ever
// removed unasked.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/unfinished.hpp"

namespace turgor {

/// The numbers of a complete output.
constexpr const char* kReportFile = "report.json";

/// What becomes of files in the goal that turgor did not write, or that were changed since.
enum class Foreign { kRefuse, kRemove };

/// Folders around the results that did not exist; those that stay empty go again.
struct MadeFolders {
  std::vector<std::filesystem::path> paths;  // inner ones first

  MadeFolders() = default;
  MadeFolders(MadeFolders&&) = default;
  MadeFolders& operator=(MadeFolders&&) = default;
  ~MadeFolders();
};

class OutputFolder {
 public:
  /// Error: the goal is a file, a folder that is not ours, or has foreign files; it says which.
  static Result<OutputFolder> create(const std::filesystem::path& goal, Foreign foreign = Foreign::kRefuse);

  /// Where to write.
  const std::filesystem::path& path() const { return partial_.path(); }
  const std::filesystem::path& goal() const { return goal_; }
  /// Foreign files that commit removes, relative to the goal.
  const std::vector<std::string>& doomed() const { return doomed_; }
  /// Error: a file lies in the earlier results, which commit replaces.
  Status check_input(const std::filesystem::path& file) const;
  /// Gives the folder its name, in place of an earlier run's. When that fails the results stay under another
  /// name, which the error says.
  Status commit();
  /// After commit: where foreign files are now that came into the goal meanwhile; empty when there were none.
  const std::filesystem::path& kept() const { return kept_; }

 private:
  OutputFolder(std::filesystem::path goal, MadeFolders made, std::vector<std::string> doomed);
  Status replace_goal();

  std::filesystem::path goal_, kept_;
  std::vector<std::string> doomed_;
  MadeFolders made_;
  Unfinished partial_;
};

/// What a person should know of others' files in the goal: those that commit will remove, and where those
/// are that came meanwhile. Empty when there are none.
std::string doomed_note(const OutputFolder& folder);
std::string kept_note(const OutputFolder& folder);

}  // namespace turgor
