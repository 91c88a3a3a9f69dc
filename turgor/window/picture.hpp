// The picture of the world in a window's own OpenGL context: what pictures of a run show, drawn by the same
// code (view/mesh_drawing.hpp). While something moves it is drawn quickly where full care takes too long.
#pragma once

#include <vector>

#include "turgor/pictures/picture_parts.hpp"
#include "turgor/view/mesh_drawing.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

struct WorldPicture {
  MeshDrawing drawing;
  GLuint framebuffer = 0;            // that holds the newest picture
  int width = 0, height = 0;         // of it [pixels]
  std::vector<PictureLabel> labels;  // words at places
  ColorScale scale;                  // where colours show a quantity
  bool has_scale = false;
  double full_seconds = 0;  // that full care takes; 0: not known yet
};

/// Error: the compiler's log.
Result<WorldPicture> make_world_picture();
/// `moves`: another picture will follow at once. Error: which call failed.
Status draw_world(const Viewer& viewer, bool moves, int width, int height, WorldPicture& picture);
/// Does a picture that is at rest lack care?
bool can_be_refined(const WorldPicture& picture);

}  // namespace turgor
