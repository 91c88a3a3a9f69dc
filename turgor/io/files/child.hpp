// Child processes: work that may crash, hang or want all memory, ours or another program's, without harm to
// this one. A child has limits, no input, no open files or handlers of its parent, and dies with it.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>

namespace turgor::io {

struct ChildLimits {
  double seconds = 60;                     // without progress, then it is killed [s]
  double processor_seconds = 24 * 3600.0;  // of all its threads together [s]
  std::size_t memory = 2ull << 30;         // address space, for our own work besides the parent's [bytes]
};

/// A started process, or why there is none.
struct Child {
  pid_t id = -1;
  int error = 0;        // errno
  bool is_ours = true;  // else a program
};

/// How a child ended.
struct ChildEnd {
  enum class Kind { kExited, kCrashed, kTooLong, kOutOfMemory, kNotStarted } kind = Kind::kExited;
  int number = 0;  // exit status, signal or errno
  explicit operator bool() const { return kind == Kind::kExited && number == 0; }
};
/// "it crashed (Segmentation fault)", "it was stopped, having got no further for 60 s", …
std::string describe(const ChildEnd& end, const ChildLimits& limits);

/// Runs `work` in a copy of this process; its result, 0 to 253, is the exit status, 255 after an exception.
Child start_child(const std::function<int()>& work, const ChildLimits& limits);
/// Runs a program of the PATH inside `folder`; what it prints as errors goes into `log` there.
Child start_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::string& log, const ChildLimits& limits);

/// Waits for all. `how_far` is asked every few milliseconds: while its number grows, nobody is stopped.
std::vector<ChildEnd> wait_for(std::span<const Child> children, const ChildLimits& limits,
                               const std::function<double()>& how_far = {});

}  // namespace turgor::io
