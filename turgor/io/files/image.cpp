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

Result<Image> read_png(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return bytes.error();
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const auto fail = [&](const char* why) {
    png_image_free(&header);
    return Error{fmt::format("{}: expected a PNG picture: {}", path.string(), why)};
  };
  if (!png_image_begin_read_from_memory(&header, bytes->data(), bytes->size())) return fail(header.message);
  constexpr png_uint_32 kMostPixels = 4096;
  if (header.width > kMostPixels || header.height > kMostPixels) return fail("it is too large");
  header.format = PNG_FORMAT_RGB;
  Image image = make_image(int(header.width), int(header.height));
  if (!png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr)) return fail(header.message);
  return image;
}

}  // namespace turgor
