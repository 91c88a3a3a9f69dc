// Child process that draws: started by exec, asked through a socket, stopped by the destructor.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include "turgor/core/result.hpp"

namespace turgor {

class DrawingChild {
 public:
  static Result<std::unique_ptr<DrawingChild>> start(const std::vector<std::string>& arguments);
  DrawingChild(const DrawingChild&) = delete;
  DrawingChild& operator=(const DrawingChild&) = delete;
  ~DrawingChild() { stop(); }

  int socket() const { return socket_; }
  /// True in the process that started it. A fork only closes its copy of the socket.
  bool is_of_this_process() const;
  /// True in the thread that started it, with whose end it is killed.
  bool is_of_this_thread() const;
  /// Kills it and describes its end, if it ended before: "crashed (Segmentation fault)".
  std::string stop();

 private:
  DrawingChild(int socket, pid_t id);
  int socket_;
  pid_t id_, process_, thread_;  // its own, and those that started it
};

}  // namespace turgor
