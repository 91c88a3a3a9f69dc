// Key bindings: one table for the actions and for the help.
#define GLFW_INCLUDE_NONE
#include <algorithm>
#include <cmath>

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/sim/scene/scene_edit.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

bool has_world(const Viewer& viewer) {
  return viewer.now && viewer.now->phase == SessionStatus::Phase::kReady &&
         !viewer.now->snapshot.bodies.empty();
}

void set_pace(Viewer& viewer, bool plays, double pace) {
  viewer.session.request(PaceRequest{.plays = plays, .pace = pace});
  viewer.message = plays ? fmt::format("playing at {:.3g} × real time", pace) : "paused";
}

template <int kDoublings>
void change_pace(Viewer& viewer) {
  if (!viewer.now) return;
  set_pace(viewer, true, std::clamp(viewer.now->pace * std::exp2(kDoublings), 1.0 / 64, 4.0));
}

template <StandardView kView>
void look_from(Viewer& viewer) {
  if (has_world(viewer)) viewer.camera = standard_view(kView, box_of(viewer.now->snapshot), viewer.aspect);
}

void look_at_all(Viewer& viewer) {
  if (!has_world(viewer)) return;
  const Vec3d direction = camera_frame(viewer.camera).back;
  viewer.camera = frame_box(box_of(viewer.now->snapshot), direction, viewer.camera.up, viewer.aspect);
}

void focus(Viewer& viewer) {
  if (!has_world(viewer)) return;
  std::optional<Vec3d> point = viewer.touching ? viewer.touching->position : viewer.touched;
  if (!point)
    if (const auto found = pick(viewer.now->snapshot, sight_ray(viewer.camera, viewer.cursor, viewer.aspect)))
      point = found->point;
  if (!point) {
    viewer.message = "no touch yet, and no body under the cursor";
    return;
  }
  const Box box = box_of(viewer.now->snapshot);
  viewer.camera = focused(viewer.camera, *point, 0.7 * norm(box.high - box.low));
}

template <MouseMode kMode>
void set_mode(Viewer& viewer) {
  viewer.mode = kMode;
}

void next_color(Viewer& viewer) {
  if (!has_world(viewer)) return;
  const std::vector<SkinColor> colors = known_colors(*viewer.now->scene);
  const auto at = std::find(colors.begin(), colors.end(), viewer.display.color);
  viewer.display.color = at == colors.end() || at + 1 == colors.end() ? colors.front() : *(at + 1);
}

void toggle_wires(Viewer& viewer) {
  MeshStyle& style = viewer.display.style;
  style = style == MeshStyle::kSurface ? MeshStyle::kWires : MeshStyle::kSurface;
}

void reset(Viewer& viewer) {
  viewer.session.request(ResetRequest{});
  viewer.message = "restarted";
}

void reload(Viewer& viewer) {
  viewer.session.request(ReloadRequest{});
  viewer.message = "scene file reloaded";
}

void save(Viewer& viewer) { viewer.message = save_scene(viewer); }

constexpr KeyHelp kKeys[] = {
    {GLFW_KEY_SPACE, "Space", "play or pause",
     [](Viewer& v) {
       if (v.now) set_pace(v, !v.now->plays, v.now->pace);
     }},
    {GLFW_KEY_PERIOD, ".", "advance one frame while paused",
     [](Viewer& v) { v.session.request(StepRequest{}); }},
    {GLFW_KEY_BACKSPACE, "Backspace", "restart with the changed parameters", reset},
    {GLFW_KEY_R, "R", "reload the scene file", reload},
    {GLFW_KEY_MINUS, "-", "half speed", change_pace<-1>},
    {GLFW_KEY_EQUAL, "+", "double speed", change_pace<1>},
    {GLFW_KEY_T, "T", "mouse mode: touch", set_mode<MouseMode::kTouch>},
    {GLFW_KEY_G, "G", "mouse mode: grab (as with Shift)", set_mode<MouseMode::kGrab>},
    {GLFW_KEY_C, "C", "mouse mode: cut skin", set_mode<MouseMode::kCut>},
    {GLFW_KEY_W, "W", "mouse mode: wind on cloth", set_mode<MouseMode::kWind>},
    {GLFW_KEY_1, "1", "view from the front", look_from<StandardView::kFront>},
    {GLFW_KEY_2, "2", "view from the back", look_from<StandardView::kBack>},
    {GLFW_KEY_3, "3", "view from the patient's right", look_from<StandardView::kRight>},
    {GLFW_KEY_4, "4", "view from the patient's left", look_from<StandardView::kLeft>},
    {GLFW_KEY_5, "5", "view from the head", look_from<StandardView::kHead>},
    {GLFW_KEY_6, "6", "view from the feet", look_from<StandardView::kFeet>},
    {GLFW_KEY_0, "0", "view the whole scene", look_at_all},
    {GLFW_KEY_F, "F", "orbit around the last touch, or the point under the cursor", focus},
    {GLFW_KEY_D, "D", "next color quantity", next_color},
    {GLFW_KEY_L, "L", "surface or wireframe", toggle_wires},
    {GLFW_KEY_U, "U", "show the fine patch that follows the tools (sfem)",
     [](Viewer& v) { v.display.patch = !v.display.patch; }},
    {GLFW_KEY_X, "X", "deformed CT: sections, volume rendering",
     [](Viewer& v) { v.panels.ct = !v.panels.ct; }},
    {GLFW_KEY_P, "P", "save a picture", [](Viewer& v) { v.wants_picture = true; }},
    {GLFW_KEY_V, "V", "start or stop a video", [](Viewer& v) { v.wants_video = !v.wants_video; }},
    {GLFW_KEY_H, "H", "save the haptic recording (for turgor replay)",
     [](Viewer& v) { v.wants_felt = true; }},
    {GLFW_KEY_S, "S", "save the scene with its changes", save},
    {GLFW_KEY_TAB, "Tab", "show or hide the panels",
     [](Viewer& v) { v.panels.controls = !v.panels.controls; }},
    {GLFW_KEY_SLASH, "?", "show or hide this help", [](Viewer& v) { v.panels.help = !v.panels.help; }},
    {GLFW_KEY_ESCAPE, "Esc", "close the help, then the window",
     [](Viewer& v) {
       v.ends = !v.panels.help;
       v.panels.help = false;
     }},
};

}  // namespace

std::span<const KeyHelp> key_table() { return kKeys; }

std::vector<SkinColor> known_colors(const Scene& scene) {
  std::vector<SkinColor> colors = {SkinColor::kNone, SkinColor::kDisplacement};
  if (!scene.lattice_bodies.empty()) colors.push_back(SkinColor::kStretch);
  if (!scene.sfem_bodies.empty()) colors.push_back(SkinColor::kPressure);
  return colors;
}

std::string save_scene(const Viewer& viewer) {
  if (!viewer.now || !viewer.now->scene) return "nothing to save: no scene is loaded";
  const Scene& scene = *viewer.now->scene;
  Result<std::string> text = with_values(scene.text, scene.file, scene.overrides);
  if (!text) return text.error().message;
  *text += incisions_text(scene, viewer.now->cuts);
  std::filesystem::path path;
  for (int n = 1; path.empty() || std::filesystem::exists(path); n++)
    path = scene.file.parent_path() / fmt::format("{}-{}.toml", scene.file.stem().string(), n);
  if (const Status written = write_file(path, *text); !written) return written.error().message;
  return "saved " + path.string();
}

}  // namespace turgor
