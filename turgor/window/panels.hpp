// What is written over the picture and beside it, with Dear ImGui: one function a panel, one a file where it
// is long. They read the viewer and do what its keys do.
#pragma once

#include "turgor/window/ct_pictures.hpp"
#include "turgor/window/picture.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

/// Rates, missed ticks, messages: always there.
void show_status(const Viewer& viewer);
/// Play, pace, mouse, display.
void show_controls(Viewer& viewer);
/// Forces of tools over time and depth, and the energy that hands gave.
void show_curves(const Viewer& viewer);
void show_parameters(Viewer& viewer);
/// Sections and volume rendering of the deformed CT.
void show_ct(Viewer& viewer, Sections& sections);
void show_help(Viewer& viewer);
/// Newtons beside arrows, the colours' legend, lines that the mouse draws.
void show_marks(const Viewer& viewer, const WorldPicture& picture);

}  // namespace turgor
