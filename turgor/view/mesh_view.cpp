#include "turgor/view/mesh_view.hpp"

#include <algorithm>

#include "turgor/view/annotate.hpp"
#include "turgor/view/gl_context.hpp"
#include "turgor/view/mesh_drawing.hpp"

namespace turgor {

namespace {

Result<Image> draw_scene(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height,
                         MeshCare care) {
  const Result<CurrentGl> gl = hold_gl();
  if (!gl) return gl.error();
  static const Result<MeshPrograms> programs = link_mesh_programs();  // guarded by holding the context
  if (!programs) return programs.error();
  static MeshDrawing& drawing =
      *new MeshDrawing;  // as the context, until the process ends: next to nothing is made anew
  drawing.programs = *programs;
  const Result<GLuint> drawn = draw_into_texture(drawing, parts, camera, width, height, care);
  if (!drawn) return drawn.error();
  return read_pixels(width, height);
}

void draw_legends(Image& image, const std::vector<MeshPart>& parts) {
  std::vector<const ColorScale*> drawn;
  for (const MeshPart& part : parts) {
    if (!part.scale || std::find(drawn.begin(), drawn.end(), part.scale) != drawn.end()) continue;
    draw_legend(image, *part.scale, int(drawn.size()));
    drawn.push_back(part.scale);
  }
}

}  // namespace

Result<Image> draw_meshes(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height,
                          MeshCare care) {
  for (const MeshPart& part : parts) {
    TURGOR_ASSERT(part.mesh, "every part of draw_meshes has a mesh");
    const std::size_t count = part.mesh->vertices.size();
    TURGOR_ASSERT(part.mesh->normals.empty() || part.mesh->normals.size() == count,
                  "one normal a vertex, or none");
    TURGOR_ASSERT(!part.scale || part.mesh->scalars.size() == count,
                  "a part with a scale has one scalar a vertex");
    TURGOR_ASSERT(!part.colors || part.colors->size() == count, "one colour a vertex");
  }
  Result<Image> image = draw_scene(parts, camera, width, height, care);
  if (image) draw_legends(*image, parts);
  return image;
}

}  // namespace turgor
