// A 64-bit content hash: equal bytes give equal hashes on every machine of the same byte order. It identifies
// states, caches and inputs; it is not for security.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace turgor {

constexpr std::uint64_t kHashSeed = 0x9e3779b97f4a7c15ull;

namespace detail {
constexpr std::uint64_t mix(std::uint64_t h, std::uint64_t word) {
  h = (h ^ word) * 0xff51afd7ed558ccdull;
  return h ^ (h >> 32);
}
}  // namespace detail

inline std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed = kHashSeed) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t h = detail::mix(seed, size);
  for (; size >= 8; size -= 8, bytes += 8) {
    std::uint64_t word;
    std::memcpy(&word, bytes, 8);
    h = detail::mix(h, word);
  }
  std::uint64_t rest = 0;
  if (size > 0) std::memcpy(&rest, bytes, size);  // `data` may be null if size is 0
  return detail::mix(h, rest);
}

/// Another hash, for long arrays: four hashes of every fourth word each, which a processor computes at once.
inline std::uint64_t hash_long_bytes(const void* data, std::size_t size, std::uint64_t seed = kHashSeed) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t h[4];
  for (std::uint64_t lane = 0; lane < 4; lane++) h[lane] = detail::mix(seed, size + lane);
  for (; size >= sizeof h; size -= sizeof h, bytes += sizeof h) {
    std::uint64_t words[4];
    std::memcpy(words, bytes, sizeof words);
    for (int lane = 0; lane < 4; lane++) h[lane] = detail::mix(h[lane], words[lane]);
  }
  return hash_bytes(bytes, size, hash_bytes(h, sizeof h, seed));
}

/// Hash of plain values that contain no padding, continued from `seed`.
template <class T>
requires std::is_trivially_copyable_v<T> std::uint64_t hash_values(std::span<const T> values,
                                                                   std::uint64_t seed = kHashSeed) {
  return hash_bytes(values.data(), values.size_bytes(), seed);
}

/// Sixteen hexadecimal digits.
inline std::string hash_text(std::uint64_t hash) {
  std::string text(16, '0');
  for (int i = 15; i >= 0; i--, hash >>= 4) text[static_cast<std::size_t>(i)] = "0123456789abcdef"[hash & 15];
  return text;
}

}  // namespace turgor
