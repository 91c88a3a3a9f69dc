// Text of others inside a sentence of ours.
#pragma once

#include <algorithm>
#include <string>

namespace turgor {

/// Control characters, which steer terminals and make lines of their own, become spaces.
inline std::string on_one_line(std::string text) {
  const auto steers = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), steers, ' ');
  return text;
}

}  // namespace turgor
