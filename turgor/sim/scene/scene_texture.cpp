#include "turgor/sim/scene/scene_texture.hpp"

namespace turgor {

namespace {

void read_height_map(SceneTable& table, HeightMapScene& map) {
  table.read_path(
      "height_map", map.file,
      "instead of `roughness`: a CSV of heights, as many numbers in each line; it repeats. One line is a "
      "profile along the path");
  table.read("spacing", map.spacing, within(1e-5, 0.1, "m"), "of the samples of `height_map`");
  table.read("scale", map.scale, inside(0, 1e3), "meters per unit of `height_map`");
  for (const char* key : {"roughness", "wavelength"})
    if (table.has("height_map") && table.has(key))
      table.fail(key, "a surface has waves or a height_map, not both");
  for (const char* key : {"spacing", "scale"})
    if (table.has(key) && !table.has("height_map"))
      table.fail(key, "belongs to a height_map: add one, or remove this key");
}

}  // namespace

void read_texture(SceneTable& body, TextureScene& texture) {
  SceneTable table = body.table("texture");
  table.read("roughness", texture.waves.roughness, within(0, 1e-3, "m"),
             "height of the surface's waves above their mean; a sliding tool vibrates. 0: smooth");
  table.read("wavelength", texture.waves.wavelength, within(1e-4, 0.1, "m"),
             "length of the waves: the tool feels the frequency speed / wavelength");
  read_height_map(table, texture.height_map);
  table.finish();
}

}  // namespace turgor
