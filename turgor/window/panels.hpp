// Panels over and beside the picture, with Dear ImGui: one function per panel, one per file if it is long.
// They read the viewer and trigger its keys.
#pragma once

#include <memory>
#include <vector>

#include "turgor/window/ct_pictures.hpp"
#include "turgor/window/gallery.hpp"
#include "turgor/window/picture.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

/// State of the session in one word.
struct StatusWord {
  std::string text;
  bool is_failure = false;
};
StatusWord status_word(const Viewer& viewer);
/// State in a word, with details on demand, and the latest message: below the picture.
void show_status(Viewer& viewer);
/// A cube that shows the directions of the patient; its faces are buttons for the views.
void show_cube(Viewer& viewer);
/// Three lines about a scene that was opened and does not play yet, with a button.
void show_start(Viewer& viewer);
/// The panel beside the picture, with the sections below. `units`: WindowScale::units.
void show_side_panel(Viewer& viewer, Sections& sections, float units);

/// The menu above the picture.
void show_menu(Viewer& viewer);
/// The dialog for files and the question about unsaved edits, if they are open.
void show_file_dialog(Viewer& viewer);
void show_question(Viewer& viewer);

/// Pictures of the scenes that come with the program.
struct GalleryPictures {
  std::vector<GalleryScene> scenes;
  std::vector<std::unique_ptr<ShownImage>> pictures;  // of `scenes`; null if there is no picture
  bool is_listed = false;
};
/// The scenes that come with the program, over the picture's area, if Viewer::shows_gallery.
void show_gallery(Viewer& viewer, GalleryPictures& pictures);

/// Length, depth and gape of a cut.
std::string cut_text(const CutResult& result);
/// State, force and gape of a stitch.
std::string stitch_text(const HandStitch& stitch);
/// Settings and pull of stitches in suture mode, and the forces of those that were made.
void show_stitches(Viewer& viewer);
/// Depth, force and layer of a needle in use.
std::string needle_text(const Viewer& viewer);
void show_needle(Viewer& viewer);
/// Play, pace, mouse, display.
void show_controls(Viewer& viewer);
/// Forces of tools over time and depth, and the energy from haptic devices.
void show_curves(const Viewer& viewer);
void show_parameters(Viewer& viewer);
/// Sections and volume rendering of the deformed CT.
void show_ct(Viewer& viewer, Sections& sections);
void show_help(Viewer& viewer);
/// Newtons beside arrows, the color legend, lines drawn with the mouse.
void show_marks(const Viewer& viewer, const WorldPicture& picture);

}  // namespace turgor
