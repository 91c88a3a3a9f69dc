#include "turgor/view/mesh_view.hpp"

#include <algorithm>

#include "turgor/view/annotate.hpp"
#include "turgor/view/drawing_process.hpp"
#include "turgor/view/gl_context.hpp"
#include "turgor/view/mesh_drawing.hpp"

namespace turgor {

Result<Image> draw_in_process(const std::vector<RenderItem>& items, const Camera& camera, int width,
                              int height, RenderQuality quality) {
  const Result<CurrentGl> gl = hold_gl();
  if (!gl) return gl.error();
  static const Result<MeshPrograms> programs = link_mesh_programs();  // guarded by holding the context
  if (!programs) return programs.error();
  static MeshDrawing& drawing =
      *new MeshDrawing;  // like the context, lives until the process ends; objects are reused
  drawing.programs = *programs;
  const Result<GLuint> drawn = draw_into_texture(drawing, items, camera, width, height, quality);
  if (!drawn) return drawn.error();
  return read_pixels(width, height);
}

namespace {

void draw_legends(Image& image, const std::vector<RenderItem>& items) {
  std::vector<const ColorScale*> drawn;
  for (const RenderItem& item : items) {
    if (!item.scale || std::find(drawn.begin(), drawn.end(), item.scale) != drawn.end()) continue;
    draw_legend(image, *item.scale, int(drawn.size()));
    drawn.push_back(item.scale);
  }
}

}  // namespace

Result<Image> draw_meshes(const std::vector<RenderItem>& items, const Camera& camera, int width, int height,
                          RenderQuality quality) {
  for (const RenderItem& item : items) {
    TURGOR_ASSERT(item.mesh, "every item of draw_meshes has a mesh");
    const std::size_t count = item.mesh->vertices.size();
    TURGOR_ASSERT(item.mesh->normals.empty() || item.mesh->normals.size() == count,
                  "one normal per vertex, or no normals");
    TURGOR_ASSERT(!item.scale || item.mesh->scalars.size() == count,
                  "an item with a scale has one scalar per vertex");
    TURGOR_ASSERT(!item.colors || item.colors->size() == count, "one color per vertex");
  }
  Result<Image> image = has_drawing_program() ? draw_in_child(items, camera, width, height, quality)
                                              : draw_in_process(items, camera, width, height, quality);
  if (image) draw_legends(*image, items);
  return image;
}

}  // namespace turgor
