#include "turgor/window/picture.hpp"

#include <algorithm>

#include "turgor/core/timing.hpp"
#include "turgor/pictures/outputs.hpp"

namespace turgor {

namespace {

constexpr double kSlow = 0.02;  // frame time above which moving pictures use the quick quality [s]

/// Color scale of the scene, or of the current values.
ColorScale scale_for(const WorldSnapshot& snapshot, const Scene& scene, SkinColor color) {
  ColorScale scale = color_scale(scene, color);
  if (scene.output.color == color && scene.output.color_range) return scale;
  if (color == SkinColor::kStretch || color == SkinColor::kPrincipalStretch) return scale;
  float high = 0;
  for (const BodySnapshot& body : snapshot.bodies)
    for (const float value : shown_values(body, color)) high = std::max(high, value);
  if (high > 0) scale.high = high;
  return scale;
}

}  // namespace

Result<WorldPicture> make_world_picture() {
  Result<MeshPrograms> programs = link_mesh_programs();
  if (!programs) return programs.error();
  WorldPicture picture;
  picture.drawing.programs = *programs;
  return picture;
}

bool can_be_refined(const WorldPicture& picture) {
  return !picture.drawing.targets || picture.framebuffer != picture.drawing.targets->picture;
}

Status draw_world(const Viewer& viewer, bool moves, int width, int height, WorldPicture& picture) {
  const WorldSnapshot& snapshot = viewer.now->snapshot;
  const SkinColor color = viewer.display.color;
  picture.has_scale = color != SkinColor::kNone;
  if (picture.has_scale) picture.scale = scale_for(snapshot, *viewer.now->scene, color);
  PictureItems items;
  LookScene look = viewer.now->scene->look;
  look.cutaway = viewer.display.cutaway, look.window = viewer.display.window;
  // fingertips of the mouse, which follow the tools of the scene, are shown while they touch
  const std::size_t tools = viewer.touching ? snapshot.tools.size() : viewer.now->scene->tools.size();
  add_world(snapshot, color, picture.has_scale ? &picture.scale : nullptr, viewer.camera.eye, items, look,
            tools);
  if (viewer.display.organ_forces) add_organ_forces(snapshot, items);
  const bool quickly = moves && (picture.full_seconds == 0 || picture.full_seconds > kSlow);
  const Timer timer;
  const Result<GLuint> drawn =
      draw_into_texture(picture.drawing, items.items, viewer.camera, width, height,
                        quickly ? RenderQuality::kQuick : RenderQuality::kFull, viewer.display.style);
  if (!drawn) return drawn.error();
  if (!quickly) glFinish(), picture.full_seconds = timer.seconds();
  picture.framebuffer = *drawn, picture.width = width, picture.height = height;
  picture.labels = std::move(items.labels);
  picture.names = viewer.now->scene->output.legend ? shown_names(items) : std::vector<NameRow>();
  return Done{};
}

}  // namespace turgor
