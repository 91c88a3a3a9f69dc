// State and actions of a viewer, independent of the window system. Events arrive as plain calls; simulation
// requests go to the session. The viewer only reads the session's snapshots.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turgor/sim/live/session.hpp"
#include "turgor/view/mesh_drawing.hpp"
#include "turgor/window/parameters.hpp"
#include "turgor/window/pick.hpp"

namespace turgor {

/// Action of the left button on a body.
enum class MouseMode : std::uint8_t { kTouch, kGrab, kCut, kWind };

/// Display options.
struct Display {
  SkinColor color = SkinColor::kNone;
  MeshStyle style = MeshStyle::kSurface;
  bool volume = false;                              // the deformed CT instead of surfaces
  bool patch = false;                               // edges of the superposed patch over the surface
  std::string preset = "skin", window = "abdomen";  // of the CT's pictures
};

/// A tool that the mouse presses or pulls with.
struct Touching {
  MouseTool tool;
  std::size_t body = 0;  // index in WorldSnapshot::bodies
  std::vector<Vec3> x;   // its surface when the touch began [m]
  std::vector<Int3> triangles;
  Vec3d position, normal;    // target of the tool's tip; unit outward normal [m]
  double tip = 0, size = 0;  // of the tool below its origin, and diameter [m]
  double depth = 0;          // target depth below `position` [m]
  bool grabs = false;
  std::chrono::steady_clock::time_point began;
};

/// A line that is being drawn on a body, or the wind over it.
struct DrawnLine {
  std::size_t body = 0;
  Vec3d from, to;  // [m]
};

/// Optional panels.
struct Panels {
  bool help = false, controls = true, parameters = false, curves = true, ct = false;
};

struct Viewer {
  Session& session;
  const SessionStatus* now = nullptr;  // newest snapshot; set once per picture
  double aspect = 4.0 / 3;
  Camera camera;
  int framed = 0;                     // number of the last world that the viewer adopted
  std::filesystem::path framed_file;  // its scene, for which the camera was set
  MouseMode mode = MouseMode::kTouch;
  Display display;
  Panels panels;
  ScreenPosition cursor;
  int teleports = 0;  // see MouseHand::put
  double depth = -1;  // of the last touch, for the next one; -1: from the tool's size [m]
  std::optional<Touching> touching;
  std::optional<Vec3d> touched;  // position of the last touch or cut, to focus on
  std::optional<DrawnLine> cut, wind;
  std::optional<int> camera_button;  // button that moves the camera while held: 0 turns, 1 shifts
  ParameterList parameters;
  std::string message;  // last status message
  bool wants_picture = false, wants_video = false, wants_felt = false, ends = false;
  std::string saved;                               // SessionStatus::saved, as last reported
  double drawn_per_second = 0;                     // pictures [1/s]
  std::chrono::steady_clock::time_point asked_ct;  // latest request
  int ct_frame = -1;                               // shown at that time
  CtTargets ct_targets;                            // of that request
  bool draws_on_device = true;                     // the last volume picture fitted into GPU memory
};

/// Mouse and keyboard. `position` is that of the cursor; key codes are those of GLFW.
void press_button(Viewer& viewer, int button, bool shift);
void release_button(Viewer& viewer);
void move_cursor(Viewer& viewer, ScreenPosition position);
void scroll(Viewer& viewer, double notches);
bool press_key(Viewer& viewer, int key, bool shift);
void open_file(Viewer& viewer, const std::filesystem::path& file);

/// Called once per picture: reads the session's snapshot and moves the tool.
void look(Viewer& viewer);

/// Adopts a new world: forgets the last touch, and frames the whole scene if the scene file is new.
void meet_world(Viewer& viewer);

/// Box of all bodies [m].
Box box_of(const WorldSnapshot& snapshot);

/// Description of a key: for press_key and for the help.
struct KeyHelp {
  int key;
  const char *name, *sentence;
  void (*act)(Viewer&);
};
std::span<const KeyHelp> key_table();
/// Description of a mouse action.
struct MouseHelp {
  const char *name, *sentence;
};
std::span<const MouseHelp> mouse_table();

/// Quantities that can color the surfaces of a scene.
std::vector<SkinColor> known_colors(const Scene& scene);
/// Saves beside the scene's file, under an unused name; returns a status message.
std::string save_scene(const Viewer& viewer);

}  // namespace turgor
