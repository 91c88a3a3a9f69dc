// Hidden folder beside the results of a run that keeps its latest autosave: ".NAME.autosave-PID-N". It
// outlives a run that is killed, and a run that is complete removes it. Its process holds a lock on it, so
// that no other run takes it.
//   state      the state (state_file.hpp); it names the files that belong to it
//   files/     files of the results that do not change any more, as hard links if the file system has them
//   growing-N/ copies of the files that still grow, of autosave N
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// A file of unfinished results.
struct SavedFile {
  std::string name;  // relative to the results
  std::uint64_t size = 0;
  bool grows = false;
};

class AutosaveFolder {
 public:
  /// Chooses a name; creates nothing yet.
  explicit AutosaveFolder(const std::filesystem::path& goal);
  /// Takes over the newest autosave of an ended run; empty if no autosave exists. Error: it cannot be
  /// renamed, or it belongs to another user.
  static Result<std::optional<AutosaveFolder>> take_over(const std::filesystem::path& goal);
  AutosaveFolder(AutosaveFolder&& other) noexcept;
  AutosaveFolder& operator=(AutosaveFolder&&) = delete;
  /// Keeps the folder.
  ~AutosaveFolder();

  std::filesystem::path state_file() const { return path_ / "state"; }
  /// Keeps the files of a folder of unfinished results for the next state. `grows`: names that still grow.
  Result<std::vector<SavedFile>> keep_files(const std::filesystem::path& results,
                                            const std::vector<std::string>& grows);
  /// New state, to be written before replace_state().
  std::filesystem::path next_state_file() const { return path_ / "state.new"; }
  /// Makes the new state the present one, and removes the growing files of the earlier one.
  Status replace_state();
  /// Brings kept files into a folder of new results. Error: a file is missing or has another size.
  Status restore_files(const std::vector<SavedFile>& files, const std::filesystem::path& results);
  /// Number of autosaves so far, of the resumed run too.
  int number() const { return number_; }
  void set_number(int number) { number_ = number; }
  /// Removes this folder and those of ended runs with the same goal.
  void remove_all();

 private:
  Status create();
  void lock();
  std::filesystem::path growing(int number) const;

  std::filesystem::path goal_, path_;
  int lock_ = -1;  // descriptor
  int number_ = 0;
};

/// Autosaves of ended runs beside a goal, newest first.
std::vector<std::filesystem::path> autosaves_beside(const std::filesystem::path& goal);

}  // namespace turgor
