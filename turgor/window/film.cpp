#include "turgor/window/film.hpp"

#include <utility>

#include <fmt/format.h>

#include "turgor/view/video.hpp"

namespace turgor {

namespace fs = std::filesystem;

fs::path free_name(const fs::path& out, const std::string& name, const char* ending) {
  fs::path path;
  for (int n = 1; path.empty() || fs::exists(path); n++) path = out / fmt::format("{}-{}{}", name, n, ending);
  return path;
}

bool is_due(const WindowFilm& film) {
  const auto passed = std::chrono::steady_clock::now() - film.latest;
  return film.frames.empty() || std::chrono::duration<double>(passed).count() >= 1 / kFilmRate;
}

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
  const fs::path path = film.folder / fmt::format("{:06}.png", film.frames.size());
  if (const Status written = write_png(path, image); !written) {
    if (film.frames.empty()) fs::remove_all(film.folder, ignored);
    return written.error().message;
  }
  film.frames.push_back(path), film.latest = std::chrono::steady_clock::now();
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
