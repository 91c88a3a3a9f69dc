// Child processes for work that may crash, hang or exhaust memory, in this program's code or another program.
// A child has limits, no input, and no open files or handlers of its parent. It ends with its parent.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>

namespace turgor::io {

struct ChildLimits {
  double seconds = 60;                     // longest time without progress before it is killed [s]
  double processor_seconds = 24 * 3600.0;  // of all its threads together [s]
  std::size_t memory = 2ull << 30;         // address space that the child may add to its parent's [bytes]
};

/// A started process, or the reason why it did not start.
struct Child {
  pid_t id = -1;
  int error = 0;        // errno
  bool is_ours = true;  // false: another program
};

/// Result of a child process.
struct ChildEnd {
  enum class Kind { kExited, kCrashed, kTooLong, kOutOfMemory, kNotStarted } kind = Kind::kExited;
  int number = 0;  // exit status, signal or errno
  explicit operator bool() const { return kind == Kind::kExited && number == 0; }
};
/// Describes the end: "it crashed (Segmentation fault)", "it made no progress for 60 s and was stopped", …
std::string describe(const ChildEnd& end, const ChildLimits& limits);

/// Runs `work` in a fork of this process. Its result, 0 to 253, is the exit status; an exception gives 255.
Child start_child(const std::function<int()>& work, const ChildLimits& limits);
/// Runs a program of the PATH inside `folder`; its standard error is written to `log` in that folder.
Child start_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::string& log, const ChildLimits& limits);

/// Waits for all children. `how_far` is called every few milliseconds; no child is stopped while its value
/// grows.
std::vector<ChildEnd> wait_for(std::span<const Child> children, const ChildLimits& limits,
                               const std::function<double()>& how_far = {});

}  // namespace turgor::io
