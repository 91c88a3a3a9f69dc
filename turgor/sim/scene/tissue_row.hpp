// Row of the report's table of tissues: component of a body, law, values and their source.
#pragma once

#include <string>

namespace turgor {

struct TissueRow {
  std::string component;  // "tissue", "skin", "inside.nodule"
  std::string law;        // "linear", "solid"
  std::string values;     // "young 5.4 kPa (preset), poisson 0.45 (default)"
  std::string source;     // of the preset, and of defaults
};

}  // namespace turgor
