// A virtual display (Xvfb) with synthetic mouse and keyboard (xdotool): the window receives the same events
// as from a user.
#pragma once

#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace turgor::test {

inline bool has_program(const char* name) {
  return std::system(fmt::format("command -v {} >/dev/null 2>&1", name).c_str()) == 0;
}

class Screen {
 public:
  Screen() {
    if (!has_program("Xvfb")) missing = "Xvfb is not installed (scripts/install-deps ci)";
    if (!has_program("xdotool")) missing = "xdotool is not installed (scripts/install-deps ci)";
    if (missing.empty()) start();
  }
  ~Screen() {
    if (server_ <= 0) return;
    kill(server_, SIGTERM);
    waitpid(server_, nullptr, 0);
  }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  std::string missing;  // the reason why no display is available

 private:
  /// Starts the server, which reports on a pipe which display is ready.
  void start() {
    int ends[2];
    if (pipe(ends) != 0) return void(missing = "no pipe");
    server_ = fork();
    if (server_ == 0) {
      close(ends[0]);
      const int nowhere = open("/dev/null", O_WRONLY);
      dup2(nowhere, STDERR_FILENO);
      dup2(nowhere, STDOUT_FILENO);
      prctl(PR_SET_PDEATHSIG, SIGTERM);  // ends with the tests, however they end
      const std::string to = std::to_string(ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", to.c_str(), "-screen", "0", "1400x900x24", "-noreset", "-nolisten",
             "tcp", nullptr);
      _exit(127);
    }
    close(ends[1]);
    const std::string display = line_of(ends[0]);
    close(ends[0]);
    if (display.empty()) return void(missing = "Xvfb did not start");
    setenv("DISPLAY", (":" + display).c_str(), 1);
  }

  /// Reads a line to its end. The server writes the newline separately and dies if the pipe is closed before.
  static std::string line_of(int pipe) {
    std::string line;
    char letter = 0;
    while (read(pipe, &letter, 1) == 1 && letter != '\n') line += letter;
    return line;
  }

  pid_t server_ = 0;
};

/// Sends the events, such as "mousemove 10 20 mousedown 1".
inline void hand(const std::string& moves) {
  if (std::system(("xdotool " + moves + " >/dev/null 2>&1").c_str()) != 0) std::abort();
}

}  // namespace turgor::test
