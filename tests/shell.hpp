// A command line as people type it: an exit code and what was printed come out.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include <sys/wait.h>

namespace turgor::test {

struct Ended {
  int code = 0;
  std::string printed;  // standard output and standard error together
};

/// A shell's command, run in a folder.
inline Ended run_command(const std::string& command, const std::filesystem::path& folder) {
  const std::string line = "cd '" + folder.string() + "' && " + command + " 2>&1";
  FILE* pipe = popen(line.c_str(), "r");
  Ended ended;
  char buffer[4096];
  while (const std::size_t size = fread(buffer, 1, sizeof buffer, pipe)) ended.printed.append(buffer, size);
  const int status = pclose(pipe);
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ended;
}

}  // namespace turgor::test
