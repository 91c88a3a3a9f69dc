// Valid names of bodies, tools, cuts, holds and obstacles in a scene. Names appear in files, reports and
// keys.
#pragma once

#include <algorithm>
#include <string_view>

namespace turgor {

/// Up to 64 characters: ASCII letters, digits, _ and -.
inline bool is_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), allowed);
}

}  // namespace turgor
