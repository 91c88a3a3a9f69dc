// Render targets of a mesh picture, pass by pass.
#pragma once

#include "turgor/view/gl.hpp"

namespace turgor {

constexpr int kShadowSize = 2048;  // pixels of the shadow map, square

/// Nearest surface in every sample, packed by the surface shader.
struct GBuffer {
  GLuint framebuffer = 0;
  GLuint colors = 0, normals = 0, depths = 0;  // textures
};

struct MeshTargets {
  GLuint shadow = 0, resolved = 0, lit = 0, occlusion = 0, picture = 0;                       // framebuffers
  GLuint shadow_depths = 0, colors = 0, normals = 0, depths = 0, lights = 0, occlusions = 0;  // textures
  GBuffer g_buffer, inner;    // of all items, and of see-through items only: created on first use
  int samples = 1;            // per pixel
  int width = 0, height = 0;  // of all targets except the shadow map
};

/// Error: the picture is larger than this OpenGL supports, or a framebuffer is not accepted.
Result<MeshTargets> make_mesh_targets(GlObjects& objects, int width, int height);

/// Render targets of a moving picture, drawn in one pass.
struct QuickTargets {
  GLuint picture = 0, backdrop = 0;  // framebuffers
  int width = 0, height = 0;
};
/// Includes the background. Error: as above.
Result<QuickTargets> make_quick_targets(GlObjects& objects, int width, int height);

/// G-buffer of the targets' size. Error: as above.
Result<GBuffer> make_g_buffer(GlObjects& objects, const MeshTargets& targets);

}  // namespace turgor
