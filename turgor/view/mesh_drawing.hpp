// The drawing of triangle meshes, in whatever OpenGL context is current: pictures make one without a window
// (mesh_view.hpp), a window has its own. What a context holds of it is in one value.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "turgor/view/mesh_targets.hpp"
#include "turgor/view/mesh_view.hpp"

namespace turgor {

struct MeshPrograms {
  GLuint shadow = 0, surface = 0, resolve = 0, smooth = 0, edge = 0, inner = 0;
  GLuint occlusion = 0, picture = 0, quick = 0;
};
/// Error: the compiler's log.
Result<MeshPrograms> link_mesh_programs();

enum class MeshStyle : std::uint8_t { kSurface, kWires };

/// Of one context, and freed while it is current. What is drawn into is kept for the next picture of the same
/// size.
struct MeshDrawing {
  MeshPrograms programs;
  std::unique_ptr<GlObjects> objects, quick_objects;
  std::optional<MeshTargets> targets;
  std::optional<QuickTargets> quick;
};

/// Draws; the answer is the framebuffer that holds the picture, rows from the bottom, and is bound. Parts as
/// in draw_meshes, without their legends. Error: which call failed.
Result<GLuint> draw_into_texture(MeshDrawing& drawing, const std::vector<MeshPart>& parts,
                                 const Camera& camera, int width, int height, MeshCare care = MeshCare::kFull,
                                 MeshStyle style = MeshStyle::kSurface);

/// What is in the framebuffer that is bound, rows from the top.
Image read_pixels(int width, int height);

}  // namespace turgor
