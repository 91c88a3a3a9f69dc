#include "turgor/window/film.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "turgor/view/video.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace {

/// Number of the frame of the present time, counted from 0.
std::size_t present_frame(const WindowFilm& film) {
  const auto passed = std::chrono::steady_clock::now() - film.begun;
  return film.frames.empty() ? 0 : std::size_t(std::chrono::duration<double>(passed).count() * kFilmRate);
}

}  // namespace

fs::path free_name(const fs::path& out, const std::string& name, const char* ending) {
  fs::path path;
  for (int n = 1; path.empty() || fs::exists(path); n++) path = out / fmt::format("{}-{}{}", name, n, ending);
  return path;
}

bool is_due(const WindowFilm& film) { return present_frame(film) >= film.frames.size(); }

std::string save_picture(const Image& image, const fs::path& out, const std::string& name) {
  std::error_code ignored;
  fs::create_directories(out, ignored);  // write_png reports errors
  const fs::path path = free_name(out, name, ".png");
  const Status written = write_png(path, image);
  return written ? "saved " + path.string() : written.error().message;
}

std::string add_to_film(const Image& image, const fs::path& out, WindowFilm& film) {
  std::error_code ignored;
  if (film.frames.empty()) film.folder = free_name(out, ".film", "");
  fs::create_directories(film.folder, ignored);
  const std::size_t frame = std::max(present_frame(film), film.frames.size());
  const fs::path path = film.folder / fmt::format("{:06}.png", frame);
  if (const Status written = write_png(path, image); !written) {
    if (film.frames.empty()) fs::remove_all(film.folder, ignored);
    return written.error().message;
  }
  if (film.frames.empty())
    film.begun = std::chrono::steady_clock::now();
  else
    film.frames.resize(frame, fs::path(film.frames.back()));
  film.frames.push_back(path);
  return fmt::format("video: {:.1f} s", double(film.frames.size()) / kFilmRate);
}

std::string end_film(const fs::path& out, const std::string& name, WindowFilm& film) {
  const fs::path path = free_name(out, name, ".mp4");
  const Status written = write_video(film.frames, kFilmRate, path);
  std::error_code ignored;
  const fs::path folder = std::exchange(film, {}).folder;
  if (written) {
    fs::remove_all(folder, ignored);
    return "saved " + path.string();
  }
  const fs::path frames = free_name(out, name + "-frames", "");
  fs::rename(folder, frames, ignored);
  return fmt::format("{}: {}", written.error().message, frames.string());
}

}  // namespace turgor
