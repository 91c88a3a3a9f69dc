// Compression as in gzip and zlib: out piece by piece, in from a range of a file.
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

/// Compresses the parts as one stream and hands on what comes out.
void deflate(std::initializer_list<std::string_view> parts, Deflate format,
             const std::function<void(std::string_view)>& out);

/// A piece of a file.
struct FileRange {
  std::filesystem::path file;
  std::int64_t begin = 0, end = 0;  // [bytes]
};

struct Inflated {
  enum class End { kExact, kTooShort, kTooLong, kDamaged } end;
  std::size_t count;  // of the bytes that were wanted, how many came
};
/// Unpacks a range that holds a stream of zlib or gzip, or several of gzip one after the other: passes over
/// the first `skip` bytes of what comes out and fills `out`. kExact: every stream ended where it should,
/// with the right checksum, when `out` was full. What follows the last stream is passed over.
Inflated inflate(const FileRange& packed, std::int64_t skip, std::span<std::byte> out);

/// Unpacks a range that holds one stream without a header or a checksum, as in DICOM. Nothing: damaged, cut
/// short, or more than `most` bytes.
std::optional<std::string> inflate_bare(const FileRange& packed, std::size_t most);

}  // namespace turgor::io
