// Files and folders that are being written. They lie hidden beside their goal, ".NAME.partial-PID-N", until
// they are complete. What is not kept is removed: by the destructor, by a signal that ends the program and,
// after a killed program, by the next one that writes to the same goal.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

class Unfinished {
 public:
  /// Chooses a name that nobody else uses; nothing is made yet.
  explicit Unfinished(const std::filesystem::path& goal);
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&&) = delete;
  ~Unfinished();

  const std::filesystem::path& path() const { return path_; }
  /// Lets `give_name` move it to where it stays; no signal removes it meanwhile. It is still unfinished when
  /// that fails.
  Status keep(const std::function<Status()>& give_name);

 private:
  std::filesystem::path path_;
};

/// Where a goal really lies: links are followed. Error: a link to nothing.
Result<std::filesystem::path> resolved_goal(const std::filesystem::path& goal);

/// What processes that are gone left beside a goal: ".NAME.KIND-PID…".
std::vector<std::filesystem::path> left_behind(const std::filesystem::path& goal, const std::string& kind);
/// A hidden name beside a goal that tells this process: ".NAME.KIND-PID".
std::filesystem::path hidden_beside(const std::filesystem::path& goal, const std::string& kind);

/// From now on SIGINT, SIGTERM, SIGHUP and SIGQUIT, unless they are ignored, remove what is unfinished and
/// end the program with code 130; a reader that went away and a file that may grow no more are errors of
/// writing, not signals. Call before other threads start: they inherit that these signals are somebody
/// else's.
void remove_unfinished_when_interrupted();

}  // namespace turgor
