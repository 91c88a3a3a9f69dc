// Drawing of triangle meshes in the current OpenGL context: pictures create one without a window
// (mesh_view.hpp), a window has its own. All OpenGL objects of a context are in one value.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "turgor/view/mesh_items.hpp"
#include "turgor/view/mesh_programs.hpp"
#include "turgor/view/mesh_targets.hpp"
#include "turgor/view/mesh_view.hpp"

namespace turgor {

/// Belongs to one context and is freed while that is current. Render targets are reused for the next picture
/// of the same size.
struct MeshDrawing {
  MeshPrograms programs;
  std::unique_ptr<GlObjects> objects, quick_objects;
  std::optional<MeshTargets> targets;
  std::optional<QuickTargets> quick;
};

/// Draws and returns the framebuffer with the picture (rows from the bottom), which is bound. Items as in
/// draw_meshes, without their legends. Error: the failed call.
Result<GLuint> draw_into_texture(MeshDrawing& drawing, const std::vector<RenderItem>& items,
                                 const Camera& camera, int width, int height,
                                 RenderQuality quality = RenderQuality::kFull,
                                 MeshStyle style = MeshStyle::kSurface);

/// Content of the bound framebuffer, rows from the top.
Image read_pixels(int width, int height);

}  // namespace turgor
