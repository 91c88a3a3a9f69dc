// Table `texture` of a body: waves of its surface, or a map of heights. Nothing is loaded here.
#pragma once

#include <filesystem>

#include "turgor/contact/texture.hpp"

namespace turgor {

/// File of heights of a textured surface.
struct HeightMapScene {
  std::filesystem::path file;  // empty = none
  double spacing = 1e-4;       // of its samples [m]
  double scale = 1;            // meters per unit of the file
};

struct TextureScene {
  contact::Waves waves;
  HeightMapScene height_map;  // instead of waves
};

}  // namespace turgor
