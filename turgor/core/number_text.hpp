// Numbers in messages of the engine, with three significant digits.
#pragma once

#include <cstdio>
#include <string>

namespace turgor {

inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace turgor
