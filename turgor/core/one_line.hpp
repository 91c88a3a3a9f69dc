// Foreign text inside a sentence of the program.
#pragma once

#include <algorithm>
#include <string>

namespace turgor {

/// Replaces control characters, which would move a terminal's cursor or break lines, by spaces.
inline std::string on_one_line(std::string text) {
  const auto steers = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), steers, ' ');
  return text;
}

}  // namespace turgor
