#include "turgor/io/mesh/vtu_blocks.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace turgor::io {

namespace {

constexpr std::array<signed char, 256> base64_values() {
  std::array<signed char, 256> values{};
  for (signed char& v : values) v = -1;
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); i++)
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<signed char>(i);
  return values;
}

/// Reads the stored bytes in order, decoded.
class StoredBytes {
 public:
  StoredBytes(std::string_view stored, bool is_base64) : stored_(stored), is_base64_(is_base64) {}

  /// Next `size` bytes; fewer at the end of the file or of the base64 text.
  std::string take(std::size_t size) {
    if (!is_base64_) {
      const std::size_t begin = std::min(at_, stored_.size());
      at_ = begin + std::min(size, stored_.size() - begin);
      return std::string(stored_.substr(begin, at_ - begin));
    }
    while (decoded_.size() < size && decode_four()) {
    }
    std::string bytes = decoded_.substr(0, size);
    decoded_.erase(0, bytes.size());
    return bytes;
  }

 private:
  /// Decodes four digits to three bytes; '=' ends a stream, and another may follow.
  bool decode_four() {
    static constexpr std::array<signed char, 256> kValues = base64_values();
    std::uint32_t bits = 0;
    int digits = 0, padding = 0;
    while (digits + padding < 4) {
      if (at_ == stored_.size()) return false;
      const char c = stored_[at_];
      const int value = kValues[static_cast<unsigned char>(c)];
      const bool is_space = c == ' ' || (c >= '\t' && c <= '\r');
      if (!is_space && value < 0 && c != '=') return false;
      at_++;
      if (is_space) continue;
      bits = bits << 6 | std::uint32_t(std::max(value, 0));
      c == '=' ? padding++ : digits++;
    }
    for (int byte = 0; byte < 3 - padding; byte++) decoded_ += char(bits >> (16 - 8 * byte) & 255);
    return true;
  }

  std::string_view stored_;
  bool is_base64_;
  std::size_t at_ = 0;
  std::string decoded_;  // decoded, but not yet taken
};

Error short_block(std::size_t expected, std::size_t found) {
  return {fmt::format("expected {} bytes, found {}", expected, found)};
}

Result<std::uint64_t> read_count(StoredBytes& stored, const BlockFormat& format) {
  std::string bytes = stored.take(std::size_t(format.header_bytes));
  if (bytes.size() != std::size_t(format.header_bytes))
    return short_block(std::size_t(format.header_bytes), bytes.size());
  if (!format.is_big_endian) std::reverse(bytes.begin(), bytes.end());
  std::uint64_t count = 0;
  for (const char c : bytes) count = count << 8 | static_cast<unsigned char>(c);
  return count;
}

/// Inflates one block to the end of `bytes`.
Status unpack(const std::string& packed, std::size_t size, std::string& bytes) {
  constexpr std::size_t kBestRatio = 1032;  // zlib's best ratio
  if (size / kBestRatio > packed.size()) return short_block(size, packed.size());
  const std::size_t before = bytes.size();
  bytes.resize(before + size);
  uLongf unpacked = uLongf(size);
  const int code = uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &unpacked,
                              reinterpret_cast<const Bytef*>(packed.data()), uLong(packed.size()));
  if (code != Z_OK || unpacked != size)
    return Error{fmt::format("expected a block of {} bytes packed by zlib, found a damaged one", size)};
  return Done{};
}

/// Header: number of blocks, bytes per block, bytes of the last one if it is shorter, compressed bytes of
/// each.
Result<std::string> read_compressed(StoredBytes& stored, const BlockFormat& format, std::size_t size) {
  std::uint64_t head[3];
  for (std::uint64_t& number : head) {
    const Result<std::uint64_t> read = read_count(stored, format);
    if (!read) return read.error();
    number = *read;
  }
  const auto [blocks, block_size, last_size] = head;
  std::vector<std::uint64_t> packed_sizes;
  for (std::uint64_t b = 0; b < blocks; b++) {
    const Result<std::uint64_t> read = read_count(stored, format);
    if (!read) return read.error();
    packed_sizes.push_back(*read);
  }
  std::string bytes;
  for (std::uint64_t b = 0; b < blocks; b++) {
    const std::uint64_t block = b + 1 == blocks && last_size > 0 ? last_size : block_size;
    if (block > size - bytes.size()) return short_block(size, bytes.size() + block);
    const std::string packed = stored.take(packed_sizes[b]);
    if (packed.size() != packed_sizes[b]) return short_block(packed_sizes[b], packed.size());
    if (Status done = unpack(packed, block, bytes); !done) return done.error();
  }
  if (bytes.size() != size) return short_block(size, bytes.size());
  return bytes;
}

}  // namespace

Result<std::string> read_block(std::string_view text, const BlockFormat& format, std::size_t size) {
  StoredBytes stored(text, format.is_base64);
  if (format.is_compressed) return read_compressed(stored, format, size);
  const Result<std::uint64_t> count = read_count(stored, format);
  if (!count) return count.error();
  if (*count != size) return short_block(size, *count);
  std::string bytes = stored.take(size);
  if (bytes.size() != size) return short_block(size, bytes.size());
  return bytes;
}

}  // namespace turgor::io
