#include "turgor/window/viewer.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/geometry/box.hpp"

namespace turgor {

ScreenPosition screen_position(const Area& area, double x, double y) {
  return {2 * (x - area.x) / area.width - 1, 1 - 2 * (y - area.y) / area.height};
}

void meet_world(Viewer& viewer) {
  viewer.touching.reset(), viewer.touched.reset(), viewer.cut.reset(), viewer.wind.reset();
  viewer.stitch.reset(), viewer.pulled.reset(), viewer.stitches.selected = -1;
  viewer.draws_on_device = true;
  const Scene& scene = *viewer.now->scene;
  const Box box = box_of(viewer.now->snapshot);
  const bool first = viewer.framed_file != scene.file;
  viewer.framed = viewer.now->world, viewer.framed_file = scene.file;
  if (first) meet_document(viewer), viewer.cut_depth = usual_depth(scene);
  if (first) viewer.display.cutaway = scene.look.cutaway;
  const std::vector<SkinColor> colors = known_colors(scene);
  if (std::find(colors.begin(), colors.end(), viewer.display.color) == colors.end())
    viewer.display.color = SkinColor::kNone;
  if (first || !meet(box, {viewer.camera.target, viewer.camera.target}))
    viewer.camera = frame_box(box, {0.35, -1, 0.35}, {0, 0, 1}, viewer.aspect);
}

Box box_of(const WorldSnapshot& snapshot) {
  std::vector<Vec3d> corners;
  for (const BodySnapshot& body : snapshot.bodies)
    for (const Vec3 x : body.x) corners.emplace_back(x);
  for (const TriMesh& obstacle : snapshot.obstacles)
    for (const Vec3 x : obstacle.vertices) corners.emplace_back(x);
  return corners.empty() ? Box{{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}} : box_around(corners);
}

bool press_key(Viewer& viewer, int key, Chord chord) {
  for (const KeyHelp& entry : key_table())
    if (entry.key == key && entry.chord == chord) return entry.act(viewer), true;
  return false;
}

void act(Viewer& viewer, std::string_view key_name) {
  for (const KeyHelp& entry : key_table())
    if (entry.name == key_name) return entry.act(viewer);
}

}  // namespace turgor
