#include <algorithm>
#include <string>

#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// A header that opens and closes a section. `is_open` may also be changed by a key; the panel then scrolls
/// to the section.
bool open_section(const char* name, bool& is_open) {
  ImGui::SetNextItemOpen(is_open, ImGuiCond_Always);
  const bool header = ImGui::CollapsingHeader(name);
  int* was_open =
      ImGui::GetStateStorage()->GetIntRef(ImGui::GetID((std::string("was ") + name).c_str()), is_open);
  if (is_open && !*was_open) ImGui::SetScrollHereY(0);
  *was_open = is_open = header;
  return is_open;
}

}  // namespace

void show_side_panel(Viewer& viewer, Sections& sections, float units) {
  Panels& panels = viewer.panels;
  if (!panels.controls) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto top = float(viewer.area.y);

  // docked on the left; its right border can be dragged
  ImGui::SetNextWindowPos({0, top});
  ImGui::SetNextWindowSize({panels.side_width * units, size.y - top}, ImGuiCond_Always);
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                      ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoSavedSettings;
  if (!ImGui::Begin("side panel", nullptr, kFlags)) return ImGui::End();
  show_controls(viewer);
  ImGui::Spacing();
  const Scene* scene = viewer.now->scene.get();
  if (open_section("Forces", panels.curves)) show_curves(viewer);
  if (scene && open_section("Parameters", panels.parameters)) show_parameters(viewer);
  if (scene && !scene->lattice_bodies.empty() && open_section("Deformed CT", panels.ct))
    show_ct(viewer, sections);
  ImGui::End();

  // splitter
  constexpr float kGrip = 8;
  ImGui::SetNextWindowPos({panels.side_width * units - 0.5f * kGrip, top});
  ImGui::SetNextWindowSize({kGrip, size.y - top});
  ImGui::SetNextWindowBgAlpha(0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2{0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2{1, 1});
  if (ImGui::Begin("splitter", nullptr,
                   kFlags | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoBackground)) {
    ImGui::InvisibleButton("grip", {kGrip, size.y - top});
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (ImGui::IsItemActive())
      panels.side_width =
          std::min(std::max(ImGui::GetIO().MousePos.x / units, 200.0f), 0.7f * size.x / units);
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace turgor
