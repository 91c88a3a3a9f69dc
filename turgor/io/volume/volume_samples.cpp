// Samples of NIfTI, NRRD and MetaImage files: raw or compressed, in either byte order, with interleaved or
// planar components.
#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "turgor/io/files/deflate.hpp"
#include "turgor/io/files/input_file.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

using InputFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

InputFile open_at(const fs::path& path, std::int64_t begin) {
  InputFile file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (file && fseeko(file.get(), off_t(begin), SEEK_SET) != 0) file.reset();
  return file;
}

/// Offset after the given number of lines; -1 if the file has fewer.
std::int64_t behind_lines(const fs::path& path, std::int64_t begin, std::int64_t lines) {
  if (lines == 0) return begin;
  const InputFile file = open_at(path, begin);
  for (int byte = 0; file && lines > 0; lines -= byte == '\n')
    if (byte = std::fgetc(file.get()); byte == EOF) return -1;
  return file ? std::int64_t(ftello(file.get())) : -1;
}

Error size_mismatch(const fs::path& path, const VolumeHeader& header, std::int64_t byte_count,
                    const std::string& found) {
  return {fmt::format(
      "{}: truncated or corrupt: the header declares {} bytes of samples ({} x {} x {}), the file holds {}",
      path.string(), byte_count, header.size[0], header.size[1], header.size[2], found)};
}

/// Byte range of the samples, or of their compressed stream, in the data file. It is checked against the file
/// size before memory is allocated.
Result<FileRange> find_samples(const fs::path& path, const VolumeHeader& header, std::int64_t byte_count) {
  if (Status input = check_input(header.data_file); !input)
    return Error{fmt::format("{}: names its data file: {}", path.string(), input.error().message)};
  std::error_code failed;
  const auto size = std::int64_t(fs::file_size(header.data_file, failed));
  FileRange range{header.data_file, behind_lines(header.data_file, header.data_offset, header.skipped_lines),
                  failed ? 0 : size};
  if (range.begin < 0)
    return Error{
        fmt::format("{}: truncated or corrupt: the samples come after {} lines, the file holds fewer",
                    path.string(), header.skipped_lines)};
  if (header.is_at_end) range.begin = std::max(range.begin, size - byte_count);
  if (!header.is_packed) range.begin += header.skipped_bytes;
  if (header.packed_length > 0 && header.packed_length > range.end - range.begin)
    return Error{fmt::format("{}: truncated or corrupt: CompressedDataSize = {}, found {} bytes",
                             path.string(), header.packed_length, range.end - range.begin)};
  if (header.packed_length > 0) range.end = range.begin + header.packed_length;
  const std::int64_t length = std::max<std::int64_t>(range.end - range.begin, 0);
  constexpr std::int64_t kBestRatio = 1100;  // of deflate
  if (header.is_packed && length * kBestRatio < byte_count + header.skipped_bytes)
    return size_mismatch(path, header, byte_count, fmt::format("{} compressed bytes", length));
  if (!header.is_packed && length < byte_count)
    return size_mismatch(path, header, byte_count, fmt::format("{}", length));
  return range;
}

Status fill(const fs::path& path, const VolumeHeader& header, const FileRange& range,
            std::span<std::byte> bytes) {
  const auto byte_count = std::int64_t(bytes.size());
  if (!header.is_packed) {
    const InputFile file = open_at(range.file, range.begin);
    const std::size_t count = file ? std::fread(bytes.data(), 1, bytes.size(), file.get()) : 0;
    return count == bytes.size() ? Status(Done{})
                                 : size_mismatch(path, header, byte_count, fmt::format("{}", count));
  }
  const Inflated inflated = inflate(range, header.skipped_bytes, bytes);
  switch (inflated.end) {
    case Inflated::End::kExact:
      return Done{};
    case Inflated::End::kTooShort:
      return size_mismatch(path, header, byte_count, fmt::format("{}", inflated.count));
    case Inflated::End::kTooLong:
      return size_mismatch(path, header, byte_count, "more than that");
    default:
      return size_mismatch(path, header, byte_count,
                           fmt::format("a damaged stream, whole up to {}", inflated.count));
  }
}

/// Interleaves components that a file stores `stride` samples apart.
std::vector<std::byte> interleaved(const std::vector<std::byte>& stored, std::size_t components,
                                   std::size_t stride, std::size_t size) {
  std::vector<std::byte> mixed(stored.size());
  auto to = mixed.begin();
  const std::size_t block = components * stride;
  for (std::size_t first = 0; first < stored.size() / size; first += block)
    for (std::size_t i = 0; i < stride; i++)
      for (std::size_t c = 0; c < components; c++)
        to = std::copy_n(stored.begin() + std::ptrdiff_t((first + c * stride + i) * size), size, to);
  return mixed;
}

RawVolume without_samples(const VolumeHeader& header) {
  return {header.format,    header.grid, header.type,        header.components, header.slope,
          header.intercept, {},          header.label_names, header.missing};
}

void swap_bytes(RawVolume& raw) {
  const std::size_t size = byte_size(raw.type);
  for (auto at = raw.bytes.begin(); size > 1 && at != raw.bytes.end(); at += std::ptrdiff_t(size))
    std::reverse(at, at + std::ptrdiff_t(size));
}

}  // namespace

Result<RawVolume> read_volume_slices(const fs::path& path, const VolumeHeader& header, int begin, int end) {
  if (header.is_packed)
    return Error{fmt::format(
        "{}: compressed; expected an uncompressed file, whose slices can be read separately", path.string())};
  RawVolume raw = without_samples(header);
  const std::size_t samples = sample_count(raw.grid) * std::size_t(raw.components) * byte_size(raw.type),
                    slice = samples / std::size_t(raw.grid.size.z);
  Result<FileRange> range = find_samples(path, header, std::int64_t(samples));
  if (!range) return range.error();
  range->begin += std::int64_t(slice) * begin;
  raw.grid.size.z = end - begin;
  raw.bytes.resize(slice * std::size_t(end - begin));
  if (Status filled = fill(path, header, *range, raw.bytes); !filled) return filled.error();
  if (header.is_swapped) swap_bytes(raw);
  return raw;
}

Result<RawVolume> read_volume_samples(const fs::path& path, const VolumeHeader& header) {
  RawVolume raw = without_samples(header);
  const std::size_t size = byte_size(raw.type), components = std::size_t(raw.components);
  const std::size_t byte_count = sample_count(raw.grid) * components * size;
  const Result<FileRange> range = find_samples(path, header, std::int64_t(byte_count));
  if (!range) return range.error();
  raw.bytes.resize(byte_count);
  if (Status filled = fill(path, header, *range, raw.bytes); !filled) return filled.error();
  if (header.is_swapped) swap_bytes(raw);
  if (components > 1 && header.component_stride > 1)
    raw.bytes = interleaved(raw.bytes, components, std::size_t(header.component_stride), size);
  return raw;
}

}  // namespace turgor::io
