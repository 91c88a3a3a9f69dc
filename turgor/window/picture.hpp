// Picture of the world in a window's own OpenGL context, drawn by the same code as pictures of runs
// (view/mesh_drawing.hpp). Moving pictures use the quick quality if the full one is too slow.
#pragma once

#include <vector>

#include "turgor/pictures/picture_items.hpp"
#include "turgor/view/mesh_drawing.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

struct WorldPicture {
  MeshDrawing drawing;
  GLuint framebuffer = 0;            // holds the newest picture
  int width = 0, height = 0;         // of it [pixels]
  std::vector<PictureLabel> labels;  // text at positions
  std::vector<NameRow> names;        // legend of bodies and inclusions
  ColorScale scale;                  // if colors show a quantity
  bool has_scale = false;
  double full_seconds = 0;  // drawing time at full quality; 0: not yet known
};

/// Error: the compiler's log.
Result<WorldPicture> make_world_picture();
/// `moves`: another picture follows at once. Error: the failed call.
Status draw_world(const Viewer& viewer, bool moves, int width, int height, WorldPicture& picture);
/// True if the picture is at rest and was drawn with the quick quality.
bool can_be_refined(const WorldPicture& picture);

}  // namespace turgor
