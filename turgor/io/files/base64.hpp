// Bytes as text that pages and XML can hold (RFC 4648).
#pragma once

#include <string>
#include <string_view>

namespace turgor::io {

std::string base64(std::string_view bytes);

}  // namespace turgor::io
