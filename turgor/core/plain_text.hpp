// Text of files, options and devices before it is printed or written to a report. Every output of the
// program passes foreign text through these functions: a terminal obeys control characters, and bidirectional
// marks show a text in another order than it has.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// `text` in which U+FFFD replaces control characters (C0, DEL, C1), marks that reorder a line, and bytes
/// that are not UTF-8. Tabs stay, and a line ends with a line feed.
std::string plain_text(std::string_view text);

/// As plain_text, on one line: tabs and line ends become spaces.
std::string on_one_line(std::string_view text);

}  // namespace turgor
