// What a picture of meshes is drawn into, pass by pass.
#pragma once

#include "turgor/view/gl.hpp"

namespace turgor {

constexpr int kShadowSize = 2048;  // pixels of the light's picture, square

struct MeshTargets {
  GLuint shadow = 0, sampled = 0, resolved = 0, occlusion = 0, picture = 0;       // framebuffers
  GLuint shadow_depths = 0, lights = 0, normals = 0, depths = 0, occlusions = 0;  // textures
  int width = 0, height = 0;                                                      // of all but the shadow
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

/// From several samples a pixel to one: light, normals, depths.
void resolve_samples(const MeshTargets& targets);

}  // namespace turgor
