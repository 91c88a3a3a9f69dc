// Panels over and beside the picture, with Dear ImGui: one function per panel, one per file if it is long.
// They read the viewer and trigger its keys.
#pragma once

#include "turgor/window/ct_pictures.hpp"
#include "turgor/window/picture.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

/// Rates, missed ticks, messages: always shown.
void show_status(const Viewer& viewer);
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
