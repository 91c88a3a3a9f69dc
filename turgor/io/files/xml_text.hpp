// Text of others inside XML, HTML and SVG: nothing in it can end a tag or an attribute, or be no text at all.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// `text` for between tags and between quotes. What is not UTF-8, and control characters besides tab and
/// line end, become U+FFFD: no document may hold them.
std::string xml_text(std::string_view text);

}  // namespace turgor
