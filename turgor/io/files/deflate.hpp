// Compression (zlib and gzip): written block by block, read from a range of a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace turgor::io {

enum class Deflate { kZlib = 15, kGzip = 15 + 16 };  // zlib's windowBits

/// Compresses the chunks as one stream and passes the output on.
void deflate(std::initializer_list<std::string_view> chunks, Deflate format,
             const std::function<void(std::string_view)>& out);

/// A byte range of a file.
struct FileRange {
  std::filesystem::path file;
  std::int64_t begin = 0, end = 0;  // [bytes]
};

struct Inflated {
  enum class End { kExact, kTooShort, kTooLong, kDamaged } end;
  std::size_t count;  // number of requested bytes that were available
};
/// Inflates a range with one zlib stream or several gzip streams in sequence. Skips the first `skip` bytes of
/// output, then fills `out`. kExact: every stream ended correctly, with the right checksum, when `out` was
/// full. Bytes after the last stream are ignored.
Inflated inflate(const FileRange& packed, std::int64_t skip, std::span<std::byte> out);

/// Inflates a range with one raw deflate stream (no header or checksum), as in DICOM. Empty if it is damaged,
/// truncated, or longer than `most` bytes.
std::optional<std::string> inflate_bare(const FileRange& packed, std::size_t most);

}  // namespace turgor::io
