// OpenGL programs of mesh pictures.
#pragma once

#include "turgor/view/gl.hpp"

namespace turgor {

/// A program of whole surfaces, and the same for one side of a plane.
struct SurfaceProgram {
  GLuint whole = 0, cut = 0;
};

struct MeshPrograms {
  SurfaceProgram shadow, surface, quick;
  GLuint resolve = 0, smooth = 0, edge = 0, inner = 0, occlusion = 0, picture = 0;
  GLuint wet_smooth = 0, wet_edge = 0;  // lighting of pixels with wet surfaces
};
/// Error: the compiler's log.
Result<MeshPrograms> link_mesh_programs();

}  // namespace turgor
