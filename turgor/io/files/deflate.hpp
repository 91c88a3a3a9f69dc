// Compression (zlib and gzip): written block by block, read from a range of a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>

#include "turgor/core/exec.hpp"

namespace turgor::io {

enum class Deflate { kZlib = 15, kGzip = 15 + 16 };  // zlib's windowBits

/// Compresses the chunks as one stream and passes the output on.
void deflate(std::initializer_list<std::string_view> chunks, Deflate format,
             const std::function<void(std::string_view)>& out);

/// The same on all threads, as one gzip stream: pieces of a mebibyte, each of which may refer to the end of
/// the one before. The output does not depend on the number of threads.
void deflate_gzip(const Exec& exec, std::initializer_list<std::string_view> chunks,
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

/// Raw deflate stream (no header or checksum), as in DICOM. It is read forward and takes the same memory
/// whatever its length.
class InflatedStream {
 public:
  explicit InflatedStream(const FileRange& packed);
  ~InflatedStream();
  /// Inflates up to `at` and fills `out` from there. Returns the number of bytes; it is smaller than
  /// requested if the stream ends or is damaged, and 0 if `at` lies before position().
  std::size_t read(std::uint64_t at, std::span<char> out);
  std::uint64_t position() const;  // inflated bytes so far
  bool is_whole() const;           // the stream has ended correctly

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace turgor::io
