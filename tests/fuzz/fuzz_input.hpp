// Shared check of the fuzz targets: it ends the program.
#pragma once

#include <cstdlib>

inline void require(bool condition) {
  if (!condition) std::abort();
}
