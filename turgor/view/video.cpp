// ffmpeg reads numbered file names. The frames are therefore linked under such names in a temporary folder
// beside the video. ffmpeg runs inside that folder and sees no user-chosen name, hence nothing that could be
// mistaken for an option.
#include "turgor/view/video.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "turgor/core/plain_text.hpp"
#include "turgor/io/files/child.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kLog = "ffmpeg.txt";
constexpr const char* kVideo = "video.mp4";

// Removes itself and its content.
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
  return Error{fmt::format("{}: cannot create a folder for the frames in {}: {}", path.string(),
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

/// Reason of a failure: the first output of ffmpeg, or how it ended.
std::string reason(const fs::path& log, const io::ChildEnd& end, const io::ChildLimits& limits) {
  constexpr std::size_t kLongest = 300;
  std::ifstream file(log);
  std::string line;
  std::getline(file, line);
  if (end.kind != io::ChildEnd::Kind::kExited || line.empty()) return io::describe(end, limits);
  return on_one_line(line.substr(0, kLongest));
}

/// True if the file starts with an MP4 box.
bool is_mp4(const fs::path& path) {
  char start[8] = {};
  std::ifstream(path, std::ios::binary).read(start, sizeof start);
  return std::string_view(start + 4, 4) == "ftyp";
}

/// Bytes that a program and its ended children have read; 0 where the system does not tell.
double bytes_read(pid_t program) {
  std::ifstream file(fmt::format("/proc/{}/io", program));
  std::string name;
  double bytes = 0;
  return file >> name >> bytes && name == "rchar:" ? bytes : 0;
}

/// Runs ffmpeg in the folder. Its progress is what it has read and written: it reads many frames before it
/// writes the first one.
Status encode(const fs::path& folder, double frames_per_second, double patience) {
  const io::ChildLimits limits{.seconds = patience, .memory = 16ull << 30};
  const io::Child child =
      io::start_program({"ffmpeg",    "-y",       "-nostdin",
                         "-xerror",  // otherwise it ignores a full disk
                         "-loglevel", "error",    "-framerate", fmt::format("{}", frames_per_second),
                         "-i",        "%06d.png", "-vf",        "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                         "-c:v",      "libx264",  "-pix_fmt",   "yuv420p",
                         "-crf",      "18",       "-movflags",  "+faststart",
                         kVideo},
                        folder, kLog, limits);
  const io::ChildEnd end = io::wait_for({&child, 1}, limits, [&] {
    std::error_code none;
    const auto size = fs::file_size(folder / kVideo, none);
    return bytes_read(child.id) + (none ? 0.0 : double(size));
  })[0];
  if (!end) return Error{"ffmpeg failed: " + reason(folder / kLog, end, limits)};
  if (!is_mp4(folder / kVideo)) return Error{"ffmpeg failed: its output is not a video"};
  return Done{};
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

Status write_video(const std::vector<fs::path>& frames, double frames_per_second, const fs::path& path,
                   double patience) {
  if (frames.empty()) return Error{fmt::format("{}: a video needs at least one frame", path.string())};
  if (!(frames_per_second > 0))
    return Error{
        fmt::format("{}: a video needs a positive frame rate, found {}", path.string(), frames_per_second)};
  if (!has_ffmpeg())
    return Error{
        fmt::format("{}: no video, because ffmpeg is not on the PATH (Debian: apt-get install ffmpeg); "
                    "the frames were written",
                    path.string())};
  const Result<fs::path> made = make_folder_beside(path);
  if (!made) return made.error();
  const WorkFolder folder(*made);
  if (const Status linked = link_frames(frames, folder.path); !linked) return linked;

  if (const Status made_video = encode(folder.path, frames_per_second, patience); !made_video)
    return Error{fmt::format("{}: {}", path.string(), made_video.error().message)};
  std::error_code error;
  fs::rename(folder.path / kVideo, path, error);
  if (error) return Error{fmt::format("{}: cannot write the video: {}", path.string(), error.message())};
  return Done{};
}

}  // namespace turgor
