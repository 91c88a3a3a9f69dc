// Pictures and videos of a window, with a key each, under names that are free.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/io/files/image.hpp"

namespace turgor {

constexpr double kFilmRate = 20;  // pictures a second of a video

/// A video on its way: pictures in a hidden folder.
struct Film {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> frames;
  std::chrono::steady_clock::time_point latest;
};

/// NAME-1, NAME-2 … with an ending: the first that is not there.
std::filesystem::path free_name(const std::filesystem::path& out, const std::string& name,
                                const char* ending);

/// All answer a sentence.
std::string save_picture(const Image& image, const std::filesystem::path& out, const std::string& name);
/// Adds the picture when it is time for the next.
std::string add_to_film(const Image& image, const std::filesystem::path& out, Film& film);
/// Where no video can be made, the pictures stay, in a folder that is named.
std::string end_film(const std::filesystem::path& out, const std::string& name, Film& film);
/// Is it time for the next?
bool is_due(const Film& film);

}  // namespace turgor
