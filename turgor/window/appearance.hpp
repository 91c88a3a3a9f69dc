// Fonts and colors of Dear ImGui, scaled to the monitor.
#pragma once

#include <imgui.h>

#include "turgor/window/settings.hpp"

namespace turgor {

/// Scale of a window: of its monitor, and framebuffer pixels per unit of window coordinates.
struct WindowScale {
  float monitor = 1, framebuffer = 1;

  /// Units of window coordinates per pixel of a monitor without scaling.
  float units() const { return monitor / framebuffer; }
  bool operator==(const WindowScale&) const = default;
};

/// Sets colors and sizes of the style.
void set_appearance(const Appearance& appearance, WindowScale scale);
/// Sets the font. Its texture must be made again.
void set_font(float text_size, WindowScale scale);

/// Colors of text in the present theme.
ImVec4 failure_color();
ImVec4 success_color();
ImVec4 plain_color();
/// Color of axes, and of curves.
ImU32 axis_color();
ImU32 curve_color();

}  // namespace turgor
