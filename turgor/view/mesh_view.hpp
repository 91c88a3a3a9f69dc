// Pictures of triangle meshes by OpenGL through EGL: no window, no display, no X server; with or without a
// GPU.
#pragma once

#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"
#include "turgor/view/cutaway.hpp"

namespace turgor {

/// kFull: per-pixel lighting with shadows, ambient occlusion and smooth edges. kQuick: one pass with lighting
/// per vertex, for moving pictures without a GPU.
enum class RenderQuality : std::uint8_t { kFull, kQuick };

/// Picture on the face of a cut-away, such as gray values of a CT.
struct FacePicture {
  Vec3d corner;     // center of the first pixel of the first row [m]
  Vec3d right, up;  // to the next pixel, and to the next row [m]
  Image image;
};

struct RenderItem {
  const TriMesh* mesh = nullptr;
  Rgb color{224, 172, 145};                  // without a scale
  const ColorScale* scale = nullptr;         // color by mesh->scalars, with a legend
  const std::vector<Rgb>* colors = nullptr;  // one per vertex, instead of `color`
  bool see_through = false;                  // also visible, but paler, behind tissue
  bool opaque = false;                       // no tissue: hides see-through items behind it, apart from marks
  bool is_mark = false;   // an arrow: a see-through one is visible behind opaque items, too
  bool in_fours = false;  // triangles of loop_subdivision; a quick picture of many replaces four by one
  bool closed = false;    // triangles are counter-clockwise seen from outside; back faces are culled
  bool wet = false;  // a film of water reflects (wet_reflection.hpp), except where a color map shows values
  Cutaway cutaway;   // not drawn, and casts no shadow
  bool is_cut_face = false;  // the section of a closed mesh by the planes of its cut-away, not its surface
  std::vector<FacePicture> face_pictures = {};  // of a section, one per plane; empty: `color`
};

/// Both sides of every triangle are drawn. Missing normals are computed. Scalars that are NaN show the item's
/// color. OpenGL runs in a child process if the program has one (drawing_process.hpp). Error: OpenGL or EGL
/// is missing on this machine, or failed; the message names the call. Or the child ended; the message says
/// how.
Result<Image> draw_meshes(const std::vector<RenderItem>& items, const Camera& camera, int width, int height,
                          RenderQuality quality = RenderQuality::kFull);

/// The same in this process, and without legends.
Result<Image> draw_in_process(const std::vector<RenderItem>& items, const Camera& camera, int width,
                              int height, RenderQuality quality);

}  // namespace turgor
