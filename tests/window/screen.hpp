// A display without a screen (Xvfb), and a hand on its mouse and keyboard (xdotool): what the window gets is
// what it gets from a person.
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

  std::string missing;  // why there is none

 private:
  /// The server says on a pipe which display is free and ready.
  void start() {
    int ends[2];
    if (pipe(ends) != 0) return void(missing = "no pipe");
    server_ = fork();
    if (server_ == 0) {
      close(ends[0]);
      const int nowhere = open("/dev/null", O_WRONLY);
      dup2(nowhere, STDERR_FILENO);
      dup2(nowhere, STDOUT_FILENO);
      prctl(PR_SET_PDEATHSIG, SIGTERM);  // it ends with the tests, however they end
      const std::string to = std::to_string(ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", to.c_str(), "-screen", "0", "1024x800x24", "-noreset", "-nolisten",
             "tcp", nullptr);
      _exit(127);
    }
    close(ends[1]);
    const std::string display = line_of(ends[0]);
    close(ends[0]);
    if (display.empty()) return void(missing = "Xvfb did not start");
    setenv("DISPLAY", (":" + display).c_str(), 1);
  }

  /// To its end: the server writes the end of the line by itself, and dies when nobody is left to read it.
  static std::string line_of(int pipe) {
    std::string line;
    char letter = 0;
    while (read(pipe, &letter, 1) == 1 && letter != '\n') line += letter;
    return line;
  }

  pid_t server_ = 0;
};

/// "mousemove 10 20 mousedown 1"
inline void hand(const std::string& moves) {
  if (std::system(("xdotool " + moves + " >/dev/null 2>&1").c_str()) != 0) std::abort();
}

}  // namespace turgor::test
