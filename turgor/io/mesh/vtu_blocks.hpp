// Values of a DataArray in a .vtu: text, base64 or raw bytes, with or without zlib compression. Internal to
// io/.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// Byte encoding of a .vtu.
struct BlockFormat {
  bool is_base64 = false;
  bool is_compressed = false;
  int header_bytes = 4;  // size of the numbers before a block: 4 or 8
  bool is_big_endian = false;
};

/// Decoded bytes of the array at the start of `stored`, exactly `size`. Memory is bounded by `size` and by
/// what the stored bytes can decode to. The error names no file.
Result<std::string> read_block(std::string_view stored, const BlockFormat& format, std::size_t size);

}  // namespace turgor::io
