// Start of a thread whose failure is an error and no exception. A system refuses threads when it is short of
// memory or when a limit of processes is reached.
#pragma once

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "turgor/core/result.hpp"

namespace turgor {

/// Names a thread after its purpose, for debuggers and profilers. Its own threads inherit the name.
void name_thread(std::thread& thread, const std::string& purpose);

/// `purpose` completes "cannot start the thread of …", and names the thread.
template <class Work>
Result<std::thread> start_thread(const std::string& purpose, Work&& work) {
  try {
    std::thread thread(std::forward<Work>(work));
    name_thread(thread, purpose);
    return Result<std::thread>(std::move(thread));
  } catch (const std::system_error& error) {
    return Error{"cannot start the thread of " + purpose + ": " + error.code().message() +
                 "; is memory short, or the number of processes limited (ulimit -u)?"};
  }
}

/// Number of threads that share a work, at most `wanted` and at least the calling one, when the system
/// starts only some of them.
int startable_threads(int wanted);

}  // namespace turgor
