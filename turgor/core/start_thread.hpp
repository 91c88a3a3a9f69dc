// Start of a thread whose failure is an error and no exception. A system refuses threads when it is short of
// memory or when a limit of processes is reached.
#pragma once

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "turgor/core/result.hpp"

namespace turgor {

/// `purpose` completes "cannot start the thread of …".
template <class Work>
Result<std::thread> start_thread(const std::string& purpose, Work&& work) {
  try {
    return std::thread(std::forward<Work>(work));
  } catch (const std::system_error& error) {
    return Error{"cannot start the thread of " + purpose + ": " + error.code().message() +
                 "; is memory short, or the number of processes limited (ulimit -u)?"};
  }
}

/// Number of threads that share a work, at most `wanted` and at least the calling one, when the system
/// starts only some of them.
int startable_threads(int wanted);

}  // namespace turgor
