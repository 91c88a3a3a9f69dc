#include "turgor/view/drawing_child.hpp"

#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace turgor {

namespace {

Error not_started(int reason) {
  return {fmt::format("cannot draw: the process that draws cannot be started: {}", std::strerror(reason))};
}

}  // namespace

DrawingChild::DrawingChild(int socket, pid_t id)
    : socket_(socket), id_(id), process_(getpid()), thread_(gettid()) {}

bool DrawingChild::is_of_this_process() const { return process_ == getpid(); }
bool DrawingChild::is_of_this_thread() const { return is_of_this_process() && thread_ == gettid(); }

Result<std::unique_ptr<DrawingChild>> DrawingChild::start(const std::vector<std::string>& arguments) {
  // its standard input is a socket, its outputs are dropped
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return not_started(errno);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);

  // its signals have their defaults, and a keyboard's interrupt goes to the parent only
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none), sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  // start it
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  pid_t id = -1;
  const int failed = posix_spawn(&id, pointers[0], &files, &attributes, pointers.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  close(ends[1]);
  if (failed == 0) return std::unique_ptr<DrawingChild>(new DrawingChild(ends[0], id));
  close(ends[0]);
  return not_started(failed);
}

std::string DrawingChild::stop() {
  if (id_ <= 0) return "";
  close(std::exchange(socket_, -1));
  if (!is_of_this_process()) return id_ = -1, "";
  // a child that crashed may need some time to end
  int status = 0;
  pid_t ended = 0;
  for (int tries = 0; tries < 50 && ended == 0; tries++) {
    ended = waitpid(id_, &status, WNOHANG);
    if (ended == 0) usleep(2000);
  }
  const bool by_itself = ended == id_;
  if (ended == 0) kill(id_, SIGKILL), waitpid(id_, &status, 0);
  id_ = -1;
  if (by_itself && WIFSIGNALED(status)) return fmt::format("crashed ({})", strsignal(WTERMSIG(status)));
  return by_itself ? fmt::format("ended with status {}", WEXITSTATUS(status)) : "closed its socket";
}

}  // namespace turgor
