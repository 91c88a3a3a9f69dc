#include "turgor/io/files/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include "turgor/io/files/file.hpp"

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
  const Result<std::vector<std::uint8_t>> bytes = encode_png(image);
  if (!bytes) return Error{fmt::format("{}: {}", path.string(), bytes.error().message)};
  return write_file(path, {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
}

Result<std::vector<std::uint8_t>> encode_png(const Image& image) {
  png_image header = png_header(image);
  header.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::uint8_t> bytes(size);
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
    return Error{fmt::format("cannot encode a picture: {}", header.message)};
  bytes.resize(size);
  return bytes;
}

}  // namespace turgor
