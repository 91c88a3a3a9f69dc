// What a person sees and does, apart from the window that it happens in: events come in as plain calls, what
// is to be simulated goes to the session. It reads what the session shows and changes nothing of it.
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

/// What the left button does on a body.
enum class MouseMode : std::uint8_t { kTouch, kGrab, kCut, kWind };

/// How the world is drawn.
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
  std::size_t body = 0;  // of ShownWorld::bodies
  std::vector<Vec3> x;   // its surface when this began [m]
  std::vector<Int3> triangles;
  Vec3d place, normal;       // where the tool's tip would touch; unit, outward [m]
  double tip = 0, size = 0;  // of the tool below its origin, and across [m]
  double depth = 0;          // that it is to be below `place` [m]
  bool grabs = false;
  std::chrono::steady_clock::time_point began;
};

/// A line that is drawn on a body, or the wind over it.
struct Drawn {
  std::size_t body = 0;
  Vec3d from, to;  // [m]
};

/// Parts of the window that come and go.
struct Panels {
  bool help = false, controls = true, parameters = false, curves = true, ct = false;
};

struct Viewer {
  Session& session;
  const SessionNow* now = nullptr;  // the newest; set once a picture
  double aspect = 4.0 / 3;
  Camera camera;
  int framed = 0;                     // the world that was met last
  std::filesystem::path framed_file;  // and its scene, which the camera was set for
  MouseMode mode = MouseMode::kTouch;
  Display display;
  Panels panels;
  Seen cursor;
  int teleports = 0;  // see MouseHand::put
  double depth = -1;  // of the last touch, for the next one; -1: of the tool's size [m]
  std::optional<Touching> touching;
  std::optional<Vec3d> touched;  // where the last touch or cut was, to look at
  std::optional<Drawn> cut, wind;
  std::optional<int> camera_button;  // that moves the camera while it is held: 0 turns, 1 shifts
  ParameterList parameters;
  std::string message;  // the last that happened
  bool wants_picture = false, wants_video = false, wants_felt = false, ends = false;
  std::string saved;                               // SessionNow::saved, as it was told last
  double drawn_per_second = 0;                     // of pictures [1/s]
  std::chrono::steady_clock::time_point asked_ct;  // latest
  int ct_frame = -1;                               // that was shown then
  CtWish ct_wish;                                  // of that
  bool draws_there = true;                         // a GPU had room for a volume's picture
};

/// Mouse and keyboard. `place` is that of the cursor; keys are those of GLFW.
void press_button(Viewer& viewer, int button, bool shift);
void release_button(Viewer& viewer);
void move_cursor(Viewer& viewer, Seen place);
void scroll(Viewer& viewer, double notches);
bool press_key(Viewer& viewer, int key, bool shift);
void open_file(Viewer& viewer, const std::filesystem::path& file);

/// Once a picture: takes what the session shows, and leads the tool.
void look(Viewer& viewer);

/// A new world: what was touched is no more, and the camera looks at all of it where it is another scene's.
void meet_world(Viewer& viewer);

/// Around all that is shown [m].
Box box_of(const WorldSnapshot& snapshot);

/// What the keys do: for press_key and for the help.
struct KeyHelp {
  int key;
  const char *name, *sentence;
  void (*act)(Viewer&);
};
std::span<const KeyHelp> key_table();
/// The same for the mouse.
struct MouseHelp {
  const char *name, *sentence;
};
std::span<const MouseHelp> mouse_table();

/// What surfaces of a scene can be coloured by.
std::vector<SkinColor> known_colors(const Scene& scene);
/// Beside the scene's file, under a name that is free; answers a sentence.
std::string save_scene(const Viewer& viewer);

}  // namespace turgor
