// Base64 encoding (RFC 4648) of bytes for HTML pages and XML.
#pragma once

#include <string>
#include <string_view>

namespace turgor::io {

std::string base64(std::string_view bytes);

}  // namespace turgor::io
