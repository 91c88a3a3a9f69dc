// State and actions of a viewer, independent of the window system. Events arrive as plain calls; simulation
// requests go to the session. The viewer only reads the session's snapshots.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/sim/live/session.hpp"
#include "turgor/view/mesh_drawing.hpp"
#include "turgor/window/cut_preview.hpp"
#include "turgor/window/file_dialog.hpp"
#include "turgor/window/parameters.hpp"
#include "turgor/window/pick.hpp"
#include "turgor/window/settings.hpp"

namespace turgor {

/// Action of the left button on a body.
enum class MouseMode : std::uint8_t { kTouch, kGrab, kCut, kSuture, kWind };

/// Display options.
struct Display {
  SkinColor color = SkinColor::kNone;
  MeshStyle style = MeshStyle::kSurface;
  bool volume = false;                              // the deformed CT instead of surfaces
  std::optional<CutawayScene> cutaway;              // part of a body that is not drawn
  bool patch = false;                               // edges of the superposed patch over the surface
  bool organ_forces = false;                        // forces of attachments and contacts between bodies
  std::string preset = "skin", window = "abdomen";  // of the CT's pictures
};

/// A needle that the mouse pushes along the normal of its entry.
struct NeedleUse {
  double length = 0;         // [m]
  double goal = 0;           // depth of the tip, to which Touching::depth moves at a limited speed [m]
  bool is_held = true;       // by the button: the cursor's height then sets the goal
  bool leaves = false;       // it is withdrawn, and released outside
  double cursor = 0;         // height when the button was pressed, as ScreenPosition::y
  double pressed_depth = 0;  // goal at that time [m]
  std::chrono::steady_clock::time_point moved;
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
  std::optional<NeedleUse> needle = {};  // of a needle, which stays after the button is released
};

/// A line that is being drawn on a body, or the wind over it.
struct DrawnLine {
  std::size_t body = 0;
  Vec3d from, to;                // [m]
  Vec3d from_normal, to_normal;  // of a cut: unit, outward
  SkinLine on_skin;              // of a cut
};

/// A point on the skin, now and in the CT.
struct SkinPoint {
  Vec3d now, normal;         // [m]; unit, outward
  Vec3d rest, rest_outward;  // likewise in the CT
};
/// A stitch that is being drawn: its first point, and the second one under the cursor.
struct DrawnStitch {
  std::size_t body = 0;  // index in WorldSnapshot::bodies
  SkinPoint from;
  std::optional<SkinPoint> to;
};
/// A stitch that is pulled by dragging, and the limits of its tension.
struct PulledStitch {
  std::size_t number = 0;         // index into SessionStatus::stitches
  double cursor = 0;              // height when the button was pressed, as ScreenPosition::y
  std::optional<double> tension;  // of the stitch when the drag began [N]
  std::optional<double> goal;     // that was requested last [N]
  std::chrono::steady_clock::time_point requested;
};
constexpr double kLeastTension = 0.05, kMostTension = 10;            // of stitches by hand [N]
constexpr double kLeastStitchDepth = 5e-4, kMostStitchDepth = 0.02;  // [m]

/// Settings of the next stitch by hand.
struct StitchSettings {
  std::string thread = "nylon 3-0";
  double depth = 0.003;      // of the deep strand below the skin [m]
  bool until_closed = true;  // else it is knotted at `tension`
  double tension = 0.5;      // [N]
  int selected = -1;  // stitch that the panel pulls, index into SessionStatus::stitches; -1: the latest
};

/// Rectangle of the window, from its top left corner [units of window coordinates].
struct Area {
  double x = 0, y = 0, width = 1, height = 1;
  double aspect() const { return width / height; }
};
/// Position of a point of the window in the picture.
ScreenPosition screen_position(const Area& area, double x, double y);

/// Action that would lose unsaved cuts or changes, and waits for the answer to a question.
enum class Leaving : std::uint8_t { kNothing, kQuit, kOpen, kRestart, kReload };

/// The scene file of a viewer, its dialog, and what was saved of it.
struct Document {
  FileDialog dialog;
  std::filesystem::path file;  // that Save writes; empty: the scene's own
  bool is_example = false;     // from the gallery: Save asks for a name
  std::string text;            // of the file, as written last; empty: as read by the session
  std::vector<std::string> opened_overrides, saved_overrides;
  std::string saved_cuts;  // as incisions_text
  Leaving leaving = Leaving::kNothing;
  std::filesystem::path next;    // to open after the question
  bool next_is_example = false;  // likewise
};

struct Viewer {
  Session& session;
  const SessionStatus* now = nullptr;  // newest snapshot; set once per picture
  Area area;                           // of the picture; panels cover the rest of the window
  double aspect = 4.0 / 3;             // of `area`
  // heights of the menu and of the line below the picture, as last drawn [units of window coordinates]
  double menu_height = 0, status_height = 0;
  Camera camera;
  int framed = 0;                     // number of the last world that the viewer adopted
  std::filesystem::path framed_file;  // its scene, for which the camera was set
  MouseMode mode = MouseMode::kTouch;
  Display display;
  Settings settings;  // without the panels, which are in `panels`
  Panels panels;
  ScreenPosition cursor;
  int teleports = 0;  // see MouseHand::put
  double depth = -1;  // of the last touch, for the next one; -1: from the tool's size [m]
  std::optional<Touching> touching;
  std::optional<Vec3d> touched;  // position of the last touch or cut, to focus on
  std::optional<DrawnLine> cut, wind;
  std::optional<DrawnStitch> stitch;
  std::optional<PulledStitch> pulled;
  StitchSettings stitches;
  double cut_depth = 0.01;           // of cuts by hand below the skin [m]
  std::string clipboard;             // text for the system's clipboard; empty: none
  std::optional<int> camera_button;  // button that moves the camera while held: 0 turns, 1 shifts
  ParameterList parameters;
  std::shared_ptr<const Scene> listed;  // scene of `parameters`
  std::string parameter_filter;         // text that shown parameters contain
  Document document;
  bool shows_gallery = false;
  std::string message;  // last status message
  std::string failure;  // last message about a failure; a status message that equals it is shown in red
  bool records_picture_only = false;  // pictures and videos without the panels
  bool wants_picture = false, wants_video = false, wants_felt = false, ends = false;
  std::string saved;                               // SessionStatus::saved, as last reported
  int edits = 0;                                   // SessionStatus::edits, likewise
  double drawn_per_second = 0;                     // pictures [1/s]
  std::chrono::steady_clock::time_point asked_ct;  // latest request
  int ct_frame = -1;                               // shown at that time
  std::optional<CutawayScene> asked_cutaway;       // of the latest request
  CtTargets ct_targets;                            // of that request
  bool draws_on_device = true;                     // the last volume picture fitted into GPU memory
};

/// Mouse and keyboard. `position` is that of the cursor; key codes are those of GLFW.
void press_button(Viewer& viewer, int button, bool shift);
void release_button(Viewer& viewer, int button);
/// Ends what the left button holds: a press, a stitch that is pulled, a drawn line.
void end_press(Viewer& viewer);
void move_cursor(Viewer& viewer, ScreenPosition position);
void scroll(Viewer& viewer, double notches);
/// Modifiers of a key. Plain keys ignore Shift.
enum class Chord : std::uint8_t { kPlain, kControl, kControlShift };
bool press_key(Viewer& viewer, int key, Chord chord);

/// Called once per picture: reads the session's snapshot and moves the tool.
void look(Viewer& viewer);

/// Adopts a new world: forgets the last touch, and frames the whole scene if the scene file is new.
void meet_world(Viewer& viewer);

/// Box of all bodies [m].
Box box_of(const WorldSnapshot& snapshot);

/// Description of a key: for press_key, for menus and for the help.
struct KeyHelp {
  const char* group;
  int key;
  const char *name, *sentence;
  void (*act)(Viewer&);
  Chord chord = Chord::kPlain;
};
std::span<const KeyHelp> key_table();
/// Description of a mouse action.
struct MouseHelp {
  const char *name, *sentence;
};
/// Acts as the key with this name.
void act(Viewer& viewer, std::string_view key_name);
std::span<const MouseHelp> mouse_table();

/// Switches the cut-away of the scene on or off; without one in the scene, the near half of the first organ
/// or CT body as seen by the camera.
void toggle_cutaway(Viewer& viewer);

/// Quantities that can color the surfaces of a scene.
std::vector<SkinColor> known_colors(const Scene& scene);
/// Cuts (viewer_cut.cpp). The first two need a cut that is being drawn.
void update_preview(Viewer& viewer, Vec3d normal);
void end_cut(Viewer& viewer);
/// Stitches (viewer_suture.cpp): a press on the skin sets the first point, then the second one, which lays
/// the stitch; dragging before the button is released pulls it.
bool press_stitch(Viewer& viewer, const Picked& picked);
void move_stitch(Viewer& viewer);
void release_stitch(Viewer& viewer);
/// Stitch that the panel pulls; null without stitches.
const HandStitch* selected_stitch(const Viewer& viewer);
/// Pulls a stitch to another tension, or without one until the wound is closed.
void tighten(Viewer& viewer, const HandStitch& stitch, std::optional<double> tension);
/// Needles (viewer_needle.cpp). Length of the needle that a tool is; empty for other tools [m].
std::optional<double> needle_length(const Scene& scene, int tool);
/// The button was pressed with the needle at the surface or in the body.
void hold_needle(Viewer& viewer);
/// Pushes by this depth; negative: withdraws [m]. False without a needle in use.
bool push_needle(Viewer& viewer, double depth);
void drag_needle(Viewer& viewer);
/// Moves the needle towards its goal. Ends its use once it was withdrawn.
void move_needle(Viewer& viewer);
void withdraw_needle(Viewer& viewer);
/// Cuts the nearest lattice along a line or curve of 3D Slicer.
void cut_along_markup(Viewer& viewer, const std::filesystem::path& file);
/// Depth of the scene's first incision, or the default [m].
double usual_depth(const Scene& scene);
constexpr double kLeastDepth = 0.001, kMostDepth = 0.1;  // of cuts by hand [m]
/// Position of a picked point at rest [m]; empty if the body does not have it.
std::optional<Vec3d> rest_point(const WorldSnapshot& snapshot, const Picked& picked);
/// Copies the point under the cursor to the clipboard, in scene coordinates.
void copy_point(Viewer& viewer);

/// Files (viewer_files.cpp). Opening, quitting and restarting ask first if that loses cuts or changes.
void open_file(Viewer& viewer, const std::filesystem::path& file);
void open_example(Viewer& viewer, const std::filesystem::path& file);
void quit(Viewer& viewer);
void restart(Viewer& viewer);
/// Reads the scene file again.
void reload(Viewer& viewer);
/// True if there are cuts or changes that no file has.
bool has_unsaved_edits(const Viewer& viewer);
/// Does what a question about unsaved edits was about.
void leave(Viewer& viewer);
/// Saves to the document's file, or opens the dialog for an example.
void save(Viewer& viewer);
void save_as(Viewer& viewer, const std::filesystem::path& file);
/// Save as, but not over another existing file.
void save_new(Viewer& viewer, const std::filesystem::path& file);
/// Saves beside the scene's file, under an unused name.
void save_copy(Viewer& viewer);
void show_open_dialog(Viewer& viewer);
void show_save_dialog(Viewer& viewer);
/// Adopts a newly opened scene.
void meet_document(Viewer& viewer);

}  // namespace turgor
