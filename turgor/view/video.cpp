// ffmpeg reads numbered names, so that the frames are given such names as links in a folder of their own,
// beside the video. It runs inside that folder and sees no name that a user chose, hence nothing that could
// be mistaken for an option.
#include "turgor/view/video.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kLog = "ffmpeg.txt";
constexpr const char* kVideo = "video.mp4";

// Removes itself with all that is in it.
struct WorkFolder {
  fs::path path;
  explicit WorkFolder(fs::path where) : path(std::move(where)) {}
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

Result<fs::path> make_folder_beside(const fs::path& path) {
  std::string pattern = (folder_of(path) / ".video-XXXXXX").string();
  if (mkdtemp(pattern.data())) return fs::path(pattern);
  return Error{fmt::format("{}: cannot make a folder for the video's frames in {}: {}", path.string(),
                           folder_of(path).string(), std::strerror(errno))};
}

Status link_frames(const std::vector<fs::path>& frames, const fs::path& folder) {
  for (std::size_t i = 0; i < frames.size(); i++) {
    std::error_code error;
    const fs::path frame = fs::canonical(frames[i], error);
    if (!error) fs::create_symlink(frame, folder / fmt::format("{:06}.png", i), error);
    if (error)
      return Error{
          fmt::format("{}: cannot use this frame for a video: {}", frames[i].string(), error.message())};
  }
  return Done{};
}

// Runs a program in `folder`, its errors into the log there; its exit status, or -1.
int run_in(const fs::path& folder, std::vector<std::string> arguments) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, kLog, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = -1;
  const int failed = posix_spawnp(&child, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line.empty() ? "it gave no reason" : line;
}

}  // namespace

bool has_ffmpeg() {
  const char* folders = std::getenv("PATH");
  std::string rest = folders ? folders : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (access((fs::path(rest.substr(0, end)) / "ffmpeg").c_str(), X_OK) == 0) return true;
    rest.erase(0, end + 1);
  }
  return false;
}

Status write_video(const std::vector<fs::path>& frames, double frames_per_second, const fs::path& path) {
  if (frames.empty())
    return Error{fmt::format("{}: a video needs frames, and there are none", path.string())};
  if (!(frames_per_second > 0))
    return Error{
        fmt::format("{}: a video needs a positive frame rate, found {}", path.string(), frames_per_second)};
  if (!has_ffmpeg())
    return Error{
        fmt::format("{}: no video, because ffmpeg is not on the PATH (Debian: apt-get install ffmpeg); "
                    "the frames are there",
                    path.string())};
  const Result<fs::path> made = make_folder_beside(path);
  if (!made) return made.error();
  const WorkFolder folder(*made);
  if (const Status linked = link_frames(frames, folder.path); !linked) return linked;

  // Without -xerror a last part that could not be written (the disk is full) is no failure to ffmpeg.
  const int exit_status = run_in(folder.path, {"ffmpeg",
                                               "-y",
                                               "-xerror",
                                               "-loglevel",
                                               "error",
                                               "-framerate",
                                               fmt::format("{}", frames_per_second),
                                               "-i",
                                               "%06d.png",
                                               "-vf",
                                               "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                               "-c:v",
                                               "libx264",
                                               "-pix_fmt",
                                               "yuv420p",
                                               "-crf",
                                               "18",
                                               "-movflags",
                                               "+faststart",
                                               kVideo});
  if (exit_status != 0)
    return Error{fmt::format("{}: ffmpeg failed: {}", path.string(), first_line(folder.path / kLog))};
  std::error_code error;
  fs::rename(folder.path / kVideo, path, error);
  if (error) return Error{fmt::format("{}: cannot write the video: {}", path.string(), error.message())};
  return Done{};
}

}  // namespace turgor
