#include "turgor/io/image.hpp"

#include <cstdio>
#include <cstring>

#include <fmt/format.h>
#include <png.h>

namespace turgor {

namespace {

png_image png_header(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  return header;
}

}  // namespace

Status write_png(const std::filesystem::path& path, const Image& image) {
  png_image header = png_header(image);
  if (png_image_write_to_file(&header, path.c_str(), 0, image.pixels.data(), 0, nullptr)) return Done{};
  return Error{fmt::format("{}: cannot write the picture: {}", path.string(), header.message)};
}

Result<std::vector<std::uint8_t>> encode_png(const Image& image) {
  png_image header = png_header(image);
  png_alloc_size_t size = 0;
  if (!png_image_write_to_memory(&header, nullptr, &size, 0, image.pixels.data(), 0, nullptr))
    return Error{fmt::format("cannot encode a picture: {}", header.message)};
  std::vector<std::uint8_t> bytes(size);
  png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

}  // namespace turgor
