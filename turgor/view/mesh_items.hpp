// Items of a mesh picture as OpenGL objects, and how they are drawn with any program.
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

#include "turgor/view/gl.hpp"
#include "turgor/view/mesh_programs.hpp"
#include "turgor/view/mesh_view.hpp"
#include "turgor/view/projection.hpp"

namespace turgor {

enum class MeshStyle : std::uint8_t { kSurface, kWires };

/// An item's OpenGL objects.
struct GlMesh {
  GLuint array = 0;
  GLsizei indices = 0;
  Vec3 color;
  bool use_map = false, see_through = false, opaque = false, is_mark = false, closed = false, wet = false;
  float size = 0;  // of a see-through item [m]
  Cutaway cutaway;
  GLuint faces[2] = {0, 0};     // of a cut face: a square in each plane, which covers all items
  GLuint pictures[2] = {0, 0};  // on these faces; 0: `color`
  Vec3 to_picture[2][2];        // coordinates in a picture: dot(to_picture[face][i], x) + offset[face][i]
  float offset[2][2] = {};
};

/// OpenGL objects of the items, and the view.
struct GlScene {
  std::vector<Box> boxes;
  View view;
  std::vector<GlMesh> items, cut_faces;
};
/// Uploads what a picture of this quality shows.
GlScene upload_scene(GlObjects& objects, const std::vector<RenderItem>& items, const Camera& camera,
                     double aspect, RenderQuality quality);

/// Draw with the current program. They set the uniforms of items.
void draw_whole_items(const std::vector<GlMesh>& items, MeshStyle style);
void draw_cut_items(const std::vector<GlMesh>& items, MeshStyle style);

/// Items that a predicate accepts.
template <class Accepts>
std::vector<GlMesh> items_that(const std::vector<GlMesh>& items, const Accepts& accepts) {
  std::vector<GlMesh> accepted;
  std::copy_if(items.begin(), items.end(), std::back_inserter(accepted), accepts);
  return accepted;
}
inline bool is_cut(const GlMesh& item) { return item.cutaway.planes > 0; }
inline bool is_opaque(const GlMesh& item) { return item.opaque; }
/// See-through items that opaque ones hide, and those that nothing hides.
inline bool is_inclusion(const GlMesh& item) { return item.see_through && !item.is_mark; }
inline bool is_seen_mark(const GlMesh& item) { return item.see_through && item.is_mark; }
inline bool is_wet(const GlMesh& item) { return item.wet; }

/// Draws surfaces without what their cut-aways leave out. `use` makes a program current and sets its
/// uniforms; it is called at most once for whole items and once for cut ones.
template <class Use>
void draw_items(const std::vector<GlMesh>& items, const SurfaceProgram& program, const Use& use,
                MeshStyle style = MeshStyle::kSurface) {
  const auto is_whole = [](const GlMesh& item) { return !is_cut(item); };
  if (std::any_of(items.begin(), items.end(), is_whole))
    use(program.whole), draw_whole_items(items_that(items, is_whole), style);
  if (std::any_of(items.begin(), items.end(), is_cut))
    use(program.cut), draw_cut_items(items_that(items, is_cut), style);
}

/// Stencil bit that sections leave alone.
constexpr GLuint kFreeStencil = 0x80;

/// Draws sections of closed surfaces by the planes of their cut-aways, with a program for cut surfaces, which
/// has its uniforms. `counting` draws positions only, cut. The stencil buffer counts the surfaces behind a
/// plane: back faces minus front faces is the winding number of the plane's point, so that folded and
/// overlapping surfaces have sections, too.
void draw_cut_faces(GLuint counting, GLuint program, const std::vector<GlMesh>& faces, const View& view);

}  // namespace turgor
