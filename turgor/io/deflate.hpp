// Compression as in gzip and zlib, piece by piece. Internal to io/.
#pragma once

#include <functional>
#include <initializer_list>
#include <string_view>

namespace turgor::io {

enum class Deflate { kZlib = 15, kGzip = 15 + 16 };  // zlib's windowBits

/// Compresses the parts as one stream and hands on what comes out.
void deflate(std::initializer_list<std::string_view> parts, Deflate format,
             const std::function<void(std::string_view)>& out);

}  // namespace turgor::io
