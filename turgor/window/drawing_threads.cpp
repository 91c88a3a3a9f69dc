#include "turgor/window/drawing_threads.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/resource.h>

namespace turgor {

int lower_drawing_priority() {
  constexpr int kNice = 5;  // a third of the time of a thread that computes frames
  int count = 0;
  std::error_code ignored;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
    // Mesa names the threads of its rasterizer llvmpipe-0, llvmpipe-1, …
    std::ifstream file(task.path() / "comm");
    std::string name;
    if (!std::getline(file, name) || !name.starts_with("llvmpipe-")) continue;
    const int thread = std::atoi(task.path().filename().c_str());
    count += setpriority(PRIO_PROCESS, id_t(thread), kNice) == 0;
  }
  return count;
}

}  // namespace turgor
