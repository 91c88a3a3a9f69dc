// Key bindings: one table for the actions and for the help.
#define GLFW_INCLUDE_NONE
#include <algorithm>
#include <cmath>

#include <GLFW/glfw3.h>
#include <fmt/format.h>

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
  viewer.stitch.reset();
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

/// Leaves what is open or under way, one thing at a time; it never closes the window.
void leave_mode(Viewer& viewer) {
  if (viewer.document.leaving != Leaving::kNothing)
    viewer.document.leaving = Leaving::kNothing;
  else if (viewer.document.dialog.is_open)
    viewer.document.dialog.is_open = false;
  else if (viewer.panels.help)
    viewer.panels.help = false;
  else if (viewer.cut)
    viewer.cut.reset(), viewer.message = "no cut";
  else if (viewer.stitch)
    viewer.stitch.reset(), viewer.message = "no stitch";
  else if (viewer.touching && viewer.touching->needle)
    withdraw_needle(viewer);
  else if (viewer.touching)
    end_press(viewer);
  else
    viewer.mode = MouseMode::kTouch;
}

/// The session reports what it took back or repeated (report_edit).
void undo(Viewer& viewer) { viewer.session.request(UndoRequest{}); }
void redo(Viewer& viewer) { viewer.session.request(RedoRequest{}); }

constexpr const char *kFile = "File", *kEdit = "Edit", *kTime = "Time", *kMouseKeys = "Mouse",
                     *kView = "View", *kOutput = "Pictures and recordings";

constexpr KeyHelp kKeys[] = {
    {kFile, GLFW_KEY_O, "Ctrl+O", "open a scene", show_open_dialog, Chord::kControl},
    {kFile, GLFW_KEY_S, "Ctrl+S", "save the scene with its cuts, stitches and changes", save,
     Chord::kControl},
    {kFile, GLFW_KEY_S, "Ctrl+Shift+S", "save under another name", show_save_dialog, Chord::kControlShift},
    {kFile, GLFW_KEY_S, "S", "save a numbered copy beside the scene", save_copy},
    {kFile, GLFW_KEY_R, "R", "reload the scene file", reload},
    {kFile, GLFW_KEY_Q, "Ctrl+Q", "quit", quit, Chord::kControl},
    {kEdit, GLFW_KEY_Z, "Ctrl+Z", "undo a cut, a stitch or a change", undo, Chord::kControl},
    {kEdit, GLFW_KEY_Z, "Ctrl+Shift+Z", "redo", redo, Chord::kControlShift},
    {kEdit, GLFW_KEY_Y, "Ctrl+Y", "redo", redo, Chord::kControl},
    {kEdit, GLFW_KEY_C, "Ctrl+C", "copy the point under the cursor at rest, in scene coordinates", copy_point,
     Chord::kControl},
    {kTime, GLFW_KEY_SPACE, "Space", "play or pause",
     [](Viewer& v) {
       if (v.now) set_pace(v, !v.now->plays, v.now->pace);
     }},
    {kTime, GLFW_KEY_PERIOD, ".", "advance one frame while paused",
     [](Viewer& v) { v.session.request(StepRequest{}); }},
    {kTime, GLFW_KEY_BACKSPACE, "Backspace", "restart with the changed parameters", restart},
    {kTime, GLFW_KEY_MINUS, "-", "half speed", change_pace<-1>},
    {kTime, GLFW_KEY_EQUAL, "+", "double speed", change_pace<1>},
    {kMouseKeys, GLFW_KEY_T, "T", "touch", set_mode<MouseMode::kTouch>},
    {kMouseKeys, GLFW_KEY_G, "G", "grab (as with Shift)", set_mode<MouseMode::kGrab>},
    {kMouseKeys, GLFW_KEY_C, "C", "cut skin", set_mode<MouseMode::kCut>},
    {kMouseKeys, GLFW_KEY_K, "K", "stitch a wound", set_mode<MouseMode::kSuture>},
    {kMouseKeys, GLFW_KEY_W, "W", "wind on cloth", set_mode<MouseMode::kWind>},
    {kMouseKeys, GLFW_KEY_PAGE_DOWN, "PgDn", "push the needle by 1 mm",
     [](Viewer& v) { push_needle(v, 1e-3); }},
    {kMouseKeys, GLFW_KEY_PAGE_UP, "PgUp", "withdraw the needle by 1 mm",
     [](Viewer& v) { push_needle(v, -1e-3); }},
    {kMouseKeys, GLFW_KEY_ESCAPE, "Esc", "leave a mode, a line or a dialog; withdraw the needle", leave_mode},
    {kView, GLFW_KEY_1, "1", "from the front", look_from<StandardView::kFront>},
    {kView, GLFW_KEY_2, "2", "from the back", look_from<StandardView::kBack>},
    {kView, GLFW_KEY_3, "3", "from the patient's right", look_from<StandardView::kRight>},
    {kView, GLFW_KEY_4, "4", "from the patient's left", look_from<StandardView::kLeft>},
    {kView, GLFW_KEY_5, "5", "from the head", look_from<StandardView::kHead>},
    {kView, GLFW_KEY_6, "6", "from the feet", look_from<StandardView::kFeet>},
    {kView, GLFW_KEY_0, "0", "the whole scene", look_at_all},
    {kView, GLFW_KEY_F, "F", "orbit around the last touch, or the point under the cursor", focus},
    {kView, GLFW_KEY_D, "D", "next color quantity", next_color},
    {kView, GLFW_KEY_L, "L", "surface or wireframe", toggle_wires},
    {kView, GLFW_KEY_U, "U", "fine patch that follows the tools (sfem)",
     [](Viewer& v) { v.display.patch = !v.display.patch; }},
    {kView, GLFW_KEY_N, "N", "forces of attachments and of organs on each other, in newtons",
     [](Viewer& v) { v.display.organ_forces = !v.display.organ_forces; }},
    {kView, GLFW_KEY_A, "A", "cut a body away to see inside", toggle_cutaway},
    {kView, GLFW_KEY_X, "X", "deformed CT: sections, volume rendering",
     [](Viewer& v) { v.panels.ct = !v.panels.ct; }},
    {kView, GLFW_KEY_TAB, "Tab", "show or hide the side panel",
     [](Viewer& v) { v.panels.controls = !v.panels.controls; }},
    {kView, GLFW_KEY_SLASH, "?", "show or hide this help", [](Viewer& v) { v.panels.help = !v.panels.help; }},
    {kOutput, GLFW_KEY_P, "P", "save a picture", [](Viewer& v) { v.wants_picture = true; }},
    {kOutput, GLFW_KEY_V, "V", "start or stop a video", [](Viewer& v) { v.wants_video = !v.wants_video; }},
    {kOutput, GLFW_KEY_H, "H", "save the haptic recording (for turgor replay)",
     [](Viewer& v) { v.wants_felt = true; }},
};

}  // namespace

void toggle_cutaway(Viewer& viewer) {
  if (viewer.display.cutaway) return viewer.display.cutaway.reset();
  if (!has_world(viewer)) return;
  viewer.display.cutaway = viewer.now->scene->look.cutaway;
  for (const BodySnapshot& body : viewer.now->snapshot.bodies)
    if (!viewer.display.cutaway && body.look != Look::kCloth)
      viewer.display.cutaway =
          CutawayScene{.body = body.id, .normal = camera_frame(viewer.camera).back, .wedge = {}};
}

std::span<const KeyHelp> key_table() { return kKeys; }

std::vector<SkinColor> known_colors(const Scene& scene) {
  std::vector<SkinColor> colors = {SkinColor::kNone, SkinColor::kDisplacement};
  if (!scene.lattice_bodies.empty()) colors.push_back(SkinColor::kStretch);
  if (!scene.lattice_bodies.empty()) colors.push_back(SkinColor::kPrincipalStretch);
  if (!scene.sfem_bodies.empty()) colors.push_back(SkinColor::kPressure);
  return colors;
}

}  // namespace turgor
