// Images: 8-bit RGB, rows from the top. PNG files through libpng.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

struct Image {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;  // width · height

  Rgb& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
  Rgb at(int x, int y) const { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

inline Image make_image(int width, int height, Rgb fill = {}) {
  return {width, height, std::vector<Rgb>(std::size_t(width) * std::size_t(height), fill)};
}

/// Uses a fast compression: a fifth of the time of the best one, whose files are three quarters as large.
Status write_png(const std::filesystem::path& path, const Image& image);
Result<std::vector<std::uint8_t>> encode_png(const Image& image);
/// Picture of a file of this program. Error: no PNG, or more than 4096 pixels along a side.
Result<Image> read_png(const std::filesystem::path& path);

}  // namespace turgor
