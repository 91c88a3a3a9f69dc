// Files and folders that are being written. They are hidden beside their target as ".NAME.partial-PID-N"
// until they are complete. Unfinished ones are removed by the destructor, by a signal that ends the program,
// and after a killed program by the next one that writes to the same target. An owner holds a lock on its
// file or folder, so that leftovers are known even if their process id is that of a zombie or was used again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

class Unfinished {
 public:
  /// Chooses a unique name; creates nothing yet.
  explicit Unfinished(const std::filesystem::path& goal);
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&&) = delete;
  ~Unfinished();

  const std::filesystem::path& path() const { return path_; }
  /// Locks the file or folder, so that no other program takes it for a leftover. Call it when it was created.
  void hold();
  /// Calls `give_name` to move it to its final name, which that returns; no signal removes it meanwhile. It
  /// stays unfinished if that fails.
  Status keep(const std::function<Result<std::filesystem::path>()>& give_name);

 private:
  void let_go();

  std::filesystem::path path_;
  int lock_ = -1;  // descriptor that holds the lock
};

/// Target with links resolved. Error: a dangling link.
Result<std::filesystem::path> resolved_goal(const std::filesystem::path& goal);

/// Leftovers of ended processes beside a target: ".NAME.KIND-PID…". No process holds their lock, and no
/// process with this id has run since their last change.
std::vector<std::filesystem::path> leftovers_beside(const std::filesystem::path& goal,
                                                    const std::string& kind);
/// The same in a folder, of any target: ".….partial-PID…".
std::vector<std::filesystem::path> leftovers_in(const std::filesystem::path& folder);
/// Hidden name beside a target that contains this process id: ".NAME.KIND-PID".
std::filesystem::path hidden_beside(const std::filesystem::path& goal, const std::string& kind);

/// Unused visible name beside a target: "NAME.KIND", "NAME.KIND-2", …
std::filesystem::path unused_name_beside(const std::filesystem::path& goal, const std::string& kind);

/// Sentence that an interrupted program prints besides, such as how to go on; empty = none.
void say_when_interrupted(std::string sentence);

/// From now on SIGINT, SIGTERM, SIGHUP and SIGQUIT, unless they are ignored, remove unfinished files and end
/// the program with code 130 and a sentence that names what is complete. SIGPIPE and SIGXFSZ become write
/// errors. Must be called before other threads start, because they inherit the signal mask.
void remove_unfinished_when_interrupted();

}  // namespace turgor
