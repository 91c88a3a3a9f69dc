// The numbers of a DataArray in a .vtu: text, base64 or raw bytes, compressed by zlib or not. Internal to
// io/.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// How a .vtu stores bytes.
struct BlockFormat {
  bool is_base64 = false;
  bool is_compressed = false;
  int header_bytes = 4;  // of a number in front of a block: 4 or 8
  bool is_big_endian = false;
};

/// The bytes of the array that begins `stored`, which must be `size`: never more is allocated, and no more
/// than the stored bytes can stand for. The error says what is wrong; it names no file.
Result<std::string> read_block(std::string_view stored, const BlockFormat& format, std::size_t size);

}  // namespace turgor::io
