// Child processes for work that may crash, hang or exhaust memory. A child is always another program, started
// by exec: a copy of a process with several threads may wait forever for a lock that one of them held. A
// child has limits, no input, and no open files or handlers of its parent. It ends with its parent.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>

namespace turgor::io {

/// Lowers a limit of this process (RLIMIT_…): a signal or an error at `most`, its end `grace` later.
void lower_limit(int resource, unsigned long long most, unsigned long long grace = 0);

struct ChildLimits {
  double seconds = 60;                     // longest time without progress before it is killed [s]
  double processor_seconds = 24 * 3600.0;  // of all its threads together [s]
  std::size_t memory = 2ull << 30;         // its address space [bytes]
};

/// A started process, or the reason why it did not start.
struct Child {
  pid_t id = -1;
  int error = 0;  // errno
};

/// Result of a child process.
struct ChildEnd {
  enum class Kind { kExited, kCrashed, kTooLong, kOutOfMemory, kNotStarted } kind = Kind::kExited;
  int number = 0;  // exit status, signal or errno
  explicit operator bool() const { return kind == Kind::kExited && number == 0; }
};
/// Describes the end: "it crashed (Segmentation fault)", "it made no progress for 60 s and was stopped", …
std::string describe(const ChildEnd& end, const ChildLimits& limits);

constexpr int kSharedFile = 3;  // descriptor of `shared` in a started program

/// Runs a program of the PATH, or of a path with a slash, inside `folder`. Its standard error is written to
/// `log` in that folder. `shared`: an open file that the program gets as kSharedFile; -1: none.
Child start_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::string& log, const ChildLimits& limits, int shared = -1);

/// Waits for all children. `how_far` is called every few milliseconds; no child is stopped while its value
/// grows.
std::vector<ChildEnd> wait_for(std::span<const Child> children, const ChildLimits& limits,
                               const std::function<double()>& how_far = {});

}  // namespace turgor::io
