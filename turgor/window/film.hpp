// Pictures and videos of a window, saved by keys under unused names.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/io/files/image.hpp"

namespace turgor {

constexpr double kFilmRate = 20;  // frames per second of a video

/// A video in progress: frames in a hidden folder.
struct WindowFilm {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> frames;  // at kFilmRate; a picture may stand for several
  std::chrono::steady_clock::time_point begun;
};

/// First unused name of NAME-1, NAME-2 … with an extension.
std::filesystem::path free_name(const std::filesystem::path& out, const std::string& name,
                                const char* ending);

/// The following functions return a status message.
std::string save_picture(const Image& image, const std::filesystem::path& out, const std::string& name);
/// Adds the picture as the frame of the present time. The previous picture stands for frames that were
/// missed.
std::string add_to_film(const Image& image, const std::filesystem::path& out, WindowFilm& film);
/// If no video can be written, the frames are kept in a folder that the message names.
std::string end_film(const std::filesystem::path& out, const std::string& name, WindowFilm& film);
/// True if the next frame is due.
bool is_due(const WindowFilm& film);

}  // namespace turgor
