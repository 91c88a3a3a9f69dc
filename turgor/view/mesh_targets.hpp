// What a picture of meshes is drawn into, pass by pass.
#pragma once

#include "turgor/view/gl.hpp"

namespace turgor {

constexpr int kShadowSize = 2048;  // pixels of the light's picture, square

/// The nearest surface in every sample, packed as the shader of surfaces says.
struct SeenSurfaces {
  GLuint framebuffer = 0;
  GLuint colors = 0, normals = 0, depths = 0;  // textures
};

struct MeshTargets {
  GLuint shadow = 0, resolved = 0, lit = 0, occlusion = 0, picture = 0;                       // framebuffers
  GLuint shadow_depths = 0, colors = 0, normals = 0, depths = 0, lights = 0, occlusions = 0;  // textures
  SeenSurfaces seen, inner;   // of all parts, and of those seen through others alone: made when first needed
  int samples = 1;            // a pixel
  int width = 0, height = 0;  // of all but the shadow
};

/// Error: the picture's size is beyond this OpenGL, or it does not accept a framebuffer.
Result<MeshTargets> make_mesh_targets(GlObjects& objects, int width, int height);

/// What a picture that moves is drawn into, in one pass.
struct QuickTargets {
  GLuint picture = 0, backdrop = 0;  // framebuffers
  int width = 0, height = 0;
};
/// The backdrop is there. Error: as above.
Result<QuickTargets> make_quick_targets(GlObjects& objects, int width, int height);

/// Of the size of the targets. Error: as above.
Result<SeenSurfaces> make_seen_surfaces(GlObjects& objects, const MeshTargets& targets);

}  // namespace turgor
