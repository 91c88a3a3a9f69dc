// Escapes foreign text for XML, HTML and SVG, so that it cannot end a tag or an attribute.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// Escaped `text` for element content and for quoted attributes. Bytes that are not UTF-8, and control
/// characters except tab and line end, become U+FFFD because XML forbids them.
std::string xml_text(std::string_view text);

}  // namespace turgor
