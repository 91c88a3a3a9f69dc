// A mouse on menus and panels of a real window. Items are found by their names: the mouse moves over a panel
// until Dear ImGui reports the item below it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <imgui.h>
#include <imgui_internal.h>

#include "tests/window/window_test.hpp"

namespace turgor::test {

/// Names of the groups around an item, outermost first, and its own name.
using ItemPath = std::vector<std::string>;
/// Name of the first number of a field, its index 0.
const std::string kFirstNumber(sizeof(int), '\0');

class PanelTest : public WindowTest {
 protected:
  Viewer& viewer() { return window_->viewer(); }

  void draw_twice() { window_->draw(), window_->draw(); }
  void press() { hand("mousedown 1"), draw_twice(); }
  void release() { hand("mouseup 1"), draw_twice(); }
  void click() { press(), release(); }

  /// Panel whose name contains the text, as drawn last.
  static ImGuiWindow* panel(std::string_view name) {
    ImGuiWindow* found = nullptr;
    for (ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
      if (window->WasActive && std::string_view(window->Name).find(name) != std::string_view::npos)
        found = window;
    return found;
  }
  static ImGuiWindow* side() { return panel("side panel"); }
  /// The menu or question that was opened last.
  static ImGuiWindow* popup() {
    const ImVector<ImGuiPopupData>& open = ImGui::GetCurrentContext()->OpenPopupStack;
    return open.empty() ? nullptr : open.back().Window;
  }

  /// Moves the mouse to the center of an item. False: the panel has no such item, or it is covered.
  bool point_at(ImGuiWindow* window, const ItemPath& path) {
    if (window == nullptr) return false;
    ImGuiID id = window->ID;
    for (const std::string& name : path) id = ImHashStr(name.data(), name.size(), id);
    // again if a panel that appears takes the focus, or if the event comes late
    for (int trial = 0; trial < 5; trial++) {
      const std::optional<ImVec2> center = center_of(*window, id);
      if (center) hand(fmt::format("mousemove {:.0f} {:.0f}", center->x, center->y));
      draw_twice();
      if (center && ImGui::GetCurrentContext()->HoveredId == id) return true;
    }
    return false;
  }
  bool click_item(ImGuiWindow* window, const ItemPath& path) {
    const bool is_found = point_at(window, path);
    if (is_found) click();
    return is_found;
  }
  bool open_menu(const std::string& name) {
    if (!click_item(panel("##MainMenuBar"), {"##menubar", name})) return false;
    return draw_until([](const SessionStatus&) { return popup() != nullptr; }, 5);
  }
  /// Clicks an item of a menu of the bar.
  bool choose(const std::string& menu, const std::string& item) {
    return open_menu(menu) && click_item(popup(), {item});
  }

 private:
  /// Center of an item on the screen. Dear ImGui keeps the rectangle of the item that the keyboard would use.
  std::optional<ImVec2> center_of(ImGuiWindow& window, ImGuiID id) {
    ImGuiContext& context = *ImGui::GetCurrentContext();
    const ImRect none{1, 1, 0, 0};
    for (ImRect& rectangle : window.NavRectRel) rectangle = none;
    context.NavWindow = &window, context.NavId = id;
    window_->draw();
    const ImRect rectangle = window.NavRectRel[context.NavLayer];
    if (context.NavId == id && rectangle.Min.x < rectangle.Max.x)
      return ImGui::WindowRectRelToAbs(&window, rectangle).GetCenter();
    return {};
  }
};

}  // namespace turgor::test
