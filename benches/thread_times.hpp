// Processor time of the threads of this process, by their names (Linux). Threads that have ended are missing.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <unistd.h>

namespace turgor {

/// Processor time by the first word of a thread's name up to a dash; the first thread is "main" [s].
inline std::map<std::string, double> thread_times() {
  std::map<std::string, double> times;
  std::error_code ignored;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
    std::ifstream comm(task.path() / "comm"), stat(task.path() / "schedstat");
    std::string name;
    double nanoseconds = 0;
    if (!std::getline(comm, name) || !(stat >> nanoseconds)) continue;
    if (task.path().filename() == std::to_string(getpid())) name = "main";
    times[name.substr(0, name.find('-'))] += 1e-9 * nanoseconds;
  }
  return times;
}

}  // namespace turgor
