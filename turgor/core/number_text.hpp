// Numbers in messages of the engine, with three significant digits; integers from 1000 to a million.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace turgor {

inline std::string number_text(double value) {
  char text[32];
  const double size = std::abs(value);
  std::snprintf(text, sizeof text, size >= 1000 && size < 1e6 ? "%.0f" : "%.3g", value);
  return text;
}

}  // namespace turgor
