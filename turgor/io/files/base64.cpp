#include "turgor/io/files/base64.hpp"

#include <cstdint>

namespace turgor::io {

std::string base64(std::string_view bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t n) { return i + n < bytes.size() ? std::uint8_t(bytes[i + n]) : 0u; };
    const unsigned three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int n = 0; n < 4; n++)
      text += i + std::size_t(n) > bytes.size() ? '=' : kLetters[three >> (18 - 6 * n) & 63];
  }
  return text;
}

}  // namespace turgor::io
