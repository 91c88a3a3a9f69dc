// What a scene may call its bodies, tools, cuts, holds, obstacles, parts: names end up in files, in reports
// and in keys.
#pragma once

#include <algorithm>
#include <string_view>

namespace turgor {

/// Up to 64 letters of English, digits, _ and -.
inline bool is_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), allowed);
}

}  // namespace turgor
