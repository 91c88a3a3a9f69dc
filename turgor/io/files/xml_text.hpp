// Escapes foreign text for XML, HTML and SVG, so that it cannot end a tag or an attribute.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// Escaped plain_text for element content and for quoted attributes.
std::string xml_text(std::string_view text);

}  // namespace turgor
