// A disk that is full, without one: in a child process no file may grow beyond a few bytes.
#pragma once

#include <csignal>
#include <functional>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace turgor::test {

/// Runs `work` with files limited to this many bytes. Returns its result, or false when it crashed.
inline bool on_a_small_disk(rlim_t bytes, const std::function<bool()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);  // then writing fails, as on a full disk
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    const bool said = work();
    exit(said ? 0 : 1);  // with all that is done at exit
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace turgor::test
