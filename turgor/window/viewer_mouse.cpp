// Mouse actions: pressing, grabbing, cutting and wind on bodies, camera motion elsewhere.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/geometry/quaternion.hpp"
#include "turgor/sim/tools/tool_path.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLeft = 0, kRight = 1, kMiddle = 2;  // GLFW's
constexpr double kLift = 0.03;                     // of a tool without contact [m]
constexpr double kWindSpeed = 12;                  // for a drag over half the picture's height [m/s]

SightRay ray_at_cursor(const Viewer& viewer) {
  return sight_ray(viewer.camera, viewer.cursor, viewer.aspect);
}

/// Orients a normal towards the camera: surfaces are picked from outside, but cloth has two sides.
Vec3d towards_eye(Vec3d normal, const SightRay& ray) {
  return dot(normal, ray.direction) > 0 ? -normal : normal;
}

double tip_of(const ToolSnapshot& tool) {
  float lowest = 0;
  for (const Vec3 x : tool.mesh.vertices) lowest = std::min(lowest, x.z);
  return -double(lowest);
}

/// Sets the target of the tool: its tip `depth` below the touched position, or retracted.
void set_target(const Touching& touching, int put, double depth) {
  const Mat3d axes = axes_of(turned_to(touching.normal));
  constexpr double kTakesHold = 0.35;  // time to close after pressing [s]
  const bool holds = touching.grabs && depth > -kLift &&
                     std::chrono::duration<double>(Clock::now() - touching.began).count() > kTakesHold;
  const auto above = [&](double height) {
    return touching.position + touching.normal * (touching.tip + height);
  };
  touching.tool.device->set_target({.pose = {above(-depth), axes},
                                    .hold = holds,
                                    .teleports = put,
                                    .teleport_to = above(0.1 * touching.size)});
}

bool begin_touch(Viewer& viewer, const Picked& picked, bool grabs) {
  const WorldSnapshot& snapshot = viewer.now->snapshot;
  const BodySnapshot& body = snapshot.bodies[picked.body];
  for (const MouseTool& mouse : viewer.now->mouse) {
    const ToolSnapshot& tool = snapshot.tools[std::size_t(mouse.tool)];
    if (!(tool.body == body.id)) continue;
    const double size = std::max(tool.size, 1e-3);
    const std::optional<double> length = needle_length(*viewer.now->scene, mouse.tool);
    viewer.touching = Touching{.tool = mouse,
                               .body = picked.body,
                               .x = body.x,
                               .triangles = body.triangles,
                               .position = picked.point,
                               .normal = towards_eye(picked.normal, ray_at_cursor(viewer)),
                               .tip = tip_of(tool),
                               .size = size,
                               .depth = viewer.depth < 0 ? size / 6 : viewer.depth,
                               .grabs = grabs,
                               .began = Clock::now()};
    if (length) viewer.touching->needle = NeedleUse{.length = *length}, hold_needle(viewer);
    set_target(*viewer.touching, ++viewer.teleports, viewer.touching->depth);
    return true;
  }
  return false;
}

/// Pressing slides over the undeformed surface; a grabbed point follows the cursor.
void move_touch(Viewer& viewer) {
  Touching& touching = *viewer.touching;
  if (touching.needle) return drag_needle(viewer);
  const SightRay ray = ray_at_cursor(viewer);
  if (touching.grabs) {
    touching.position = in_plane(viewer.camera, ray, touching.position);
  } else if (const auto found = pick_surface(touching.x, touching.triangles, ray)) {
    touching.position = found->point;
    touching.normal = normalized(touching.normal * 4.0 + towards_eye(found->normal, ray));
  }
}

/// Begins a line on a body of this kind at the cursor.
bool begin_line(Viewer& viewer, const Picked& picked, BodyKind kind, std::optional<DrawnLine>& line) {
  if (viewer.now->snapshot.bodies[picked.body].id.kind != kind) return false;
  const Vec3d normal = towards_eye(picked.normal, ray_at_cursor(viewer));
  line = DrawnLine{picked.body, picked.point, picked.point, normal, normal, {}};
  return true;
}

void blow(Viewer& viewer) {
  const DrawnLine& line = *viewer.wind;
  const double half_height =
      norm(viewer.camera.eye - viewer.camera.target) * camera_frame(viewer.camera).tan_half;
  const Vec3d velocity = (line.to - line.from) * (kWindSpeed / half_height);
  viewer.session.request(
      WindRequest{.body = viewer.now->snapshot.bodies[line.body].id.index, .velocity = velocity});
  viewer.message = fmt::format("wind of {:.1f} m/s", norm(velocity));
}

/// True if the left button acts on the body under the cursor.
bool begin_on_body(Viewer& viewer, bool shift) {
  if (!viewer.now || viewer.now->phase != SessionStatus::Phase::kReady) return false;
  const auto picked = pick(viewer.now->snapshot, ray_at_cursor(viewer));
  if (!picked) return false;
  if (viewer.touching) return hold_needle(viewer), true;  // which stays in the body
  if (viewer.mode == MouseMode::kCut) return begin_line(viewer, *picked, BodyKind::kLattice, viewer.cut);
  if (viewer.mode == MouseMode::kSuture && press_stitch(viewer, *picked)) return true;
  if (viewer.mode != MouseMode::kWind &&
      begin_touch(viewer, *picked, shift || viewer.mode == MouseMode::kGrab))
    return true;
  return begin_line(viewer, *picked, BodyKind::kCloth, viewer.wind);
}

/// Minimum time between deformed CTs, which cost frames but not ticks. On the CPU a few times per second; on
/// a GPU at most the screen's rate, and an eighth of its time.
std::chrono::duration<double> pause_between(const DeformedCt* ct) {
  const double seconds = !ct || !ct->device ? 0.7 : std::max(0.03, 8 * ct->device->report.seconds);
  return std::chrono::duration<double>(seconds);
}

/// Requests a deformed CT if one is shown.
void ask_for_ct(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  const bool volume = viewer.display.volume;
  if (!(volume || viewer.panels.ct) || now.scene->lattice_bodies.empty()) return;
  const CtTargets targets{.host = viewer.panels.ct || !viewer.draws_on_device,
                          .device = volume && viewer.draws_on_device};
  const int frame = now.snapshot.frame;
  if (now.ct && now.ct->covers(targets) && (now.ct->frame == frame || viewer.ct_frame == frame)) return;
  if (targets == viewer.ct_targets && Clock::now() < viewer.asked_ct + pause_between(now.ct.get())) return;
  viewer.asked_ct = Clock::now(), viewer.ct_targets = targets, viewer.ct_frame = frame;
  viewer.session.request(CtRequest{targets});
}

/// Requests sections of the CT in the planes of the shown cut-away.
void ask_for_sections(Viewer& viewer) {
  if (viewer.asked_cutaway == viewer.display.cutaway) return;
  viewer.asked_cutaway = viewer.display.cutaway;
  viewer.session.request(CutawayRequest{viewer.display.cutaway});
}

/// Shows the result of the latest undo or redo.
void report_edit(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  if (now.edits == viewer.edits) return;
  viewer.edits = now.edits;
  if (now.edited.empty()) return;  // another world
  viewer.message = now.edited;
  if (now.edited.starts_with("not ")) viewer.failure = viewer.message;
}

constexpr MouseHelp kMouseHelp[] = {
    {"left on a body",
     "press with the body's tool, and slide; on cloth without a tool: wind; in cut mode: cut skin"},
    {"two clicks in suture mode", "a stitch; drag up or down before the second release to pull it"},
    {"left on a body with a needle", "push by dragging down or with the wheel; it stays when released"},
    {"Shift + left on a body", "grab and pull; forceps close"},
    {"wheel while pressing or drawing", "change the depth"},
    {"left off the bodies, or right", "orbit"},
    {"middle, or Shift + right", "pan"},
    {"wheel", "zoom to the cursor"},
    {"drop a file on the window", "open that scene; cut along a .mrk.json of 3D Slicer"},
};

}  // namespace

std::span<const MouseHelp> mouse_table() { return kMouseHelp; }

void press_button(Viewer& viewer, int button, bool shift) {
  viewer.camera_button.reset();
  if (button == kLeft && begin_on_body(viewer, shift)) return;
  viewer.camera_button = button == kMiddle || (button == kRight && shift) ? 1 : 0;
}

void release_button(Viewer& viewer, int button) {
  viewer.camera_button.reset();
  if (button == kLeft) end_press(viewer);
}

void end_press(Viewer& viewer) {
  release_stitch(viewer);
  if (viewer.touching && viewer.touching->needle) {
    viewer.touching->needle->is_held = false;
  } else if (viewer.touching) {
    viewer.touched = viewer.touching->position;
    viewer.touching->grabs = false;
    set_target(*viewer.touching, viewer.teleports, -kLift);
    viewer.touching.reset();
  }
  if (viewer.cut) end_cut(viewer);
  viewer.wind.reset();
}

void move_cursor(Viewer& viewer, ScreenPosition position) {
  const ScreenPosition before = viewer.cursor;
  viewer.cursor = position;
  const bool holds = viewer.touching && !(viewer.touching->needle && !viewer.touching->needle->is_held);
  if (holds) return move_touch(viewer);
  move_stitch(viewer);
  if (viewer.pulled) return;
  if (viewer.cut) {
    if (const auto found = pick(viewer.now->snapshot, ray_at_cursor(viewer));
        found && found->body == viewer.cut->body)
      viewer.cut->to = found->point,
      update_preview(viewer, towards_eye(found->normal, ray_at_cursor(viewer)));
  } else if (viewer.wind) {
    viewer.wind->to = in_plane(viewer.camera, ray_at_cursor(viewer), viewer.wind->from);
    blow(viewer);
  } else if (viewer.camera_button == 1) {
    viewer.camera = panned(viewer.camera, before, position, viewer.aspect);
  } else if (viewer.camera_button == 0) {
    constexpr double kTurn = 1.5;  // over half the picture [rad]
    viewer.camera = orbited(viewer.camera, -kTurn * viewer.aspect * (position.x - before.x),
                            -kTurn * (position.y - before.y));
  }
}

void scroll(Viewer& viewer, double notches) {
  if (viewer.cut) {
    viewer.cut_depth = std::clamp(viewer.cut_depth + 0.001 * notches, kLeastDepth, kMostDepth);
    return;
  }
  if (viewer.stitch) {
    viewer.stitches.depth =
        std::clamp(viewer.stitches.depth + 5e-4 * notches, kLeastStitchDepth, kMostStitchDepth);
    return;
  }
  constexpr double kNotch = 0.001;  // of a needle [m]
  if (push_needle(viewer, kNotch * notches)) return;
  if (viewer.touching) {
    Touching& touching = *viewer.touching;
    touching.depth =
        std::clamp(touching.depth + notches * touching.size / 30, -2 * touching.size, 2 * touching.size);
    viewer.depth = std::max(0.0, touching.depth);
    return;
  }
  viewer.camera = zoomed(viewer.camera, std::pow(0.9, notches), viewer.cursor, viewer.aspect);
}

void look(Viewer& viewer) {
  const SessionStatus& now = viewer.session.now();
  const bool ready = now.phase == SessionStatus::Phase::kReady;
  viewer.now = &now;
  if (!now.saved.empty() && now.saved != viewer.saved) viewer.message = viewer.saved = now.saved;
  report_edit(viewer);
  if (!ready || now.snapshot.bodies.empty()) {
    viewer.touching.reset(), viewer.cut.reset(), viewer.wind.reset();
    viewer.stitch.reset(), viewer.pulled.reset();
    return;
  }
  if (viewer.framed != now.world) meet_world(viewer);
  move_needle(viewer);
  if (viewer.touching) set_target(*viewer.touching, viewer.teleports, viewer.touching->depth);
  ask_for_ct(viewer), ask_for_sections(viewer);
}

}  // namespace turgor
