#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// A button with the effect of a key.
void key_button(Viewer& viewer, const char* label, const char* key) {
  if (ImGui::Button(label))
    for (const KeyHelp& entry : key_table())
      if (std::string_view(entry.name) == key) return entry.act(viewer);
}

void show_running(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  key_button(viewer, now.plays ? "Pause" : "Play ", "Space");
  ImGui::SameLine();
  key_button(viewer, "Step", ".");
  ImGui::SameLine();
  key_button(viewer, "Reset", "Backspace");
  ImGui::SameLine();
  key_button(viewer, "Slower", "-");
  ImGui::SameLine();
  key_button(viewer, "Faster", "+");
  ImGui::Text("speed %.3g × real time", now.pace);
}

void show_mouse(Viewer& viewer) {
  int mode = int(viewer.mode);
  int n = 0;
  for (const char* name : {"touch", "grab", "cut", "wind"}) {
    if (n > 0) ImGui::SameLine();
    ImGui::RadioButton(name, &mode, n++);
  }
  viewer.mode = MouseMode(mode);
  if (viewer.touching) ImGui::Text("%.1f mm deep", 1e3 * viewer.touching->depth);
}

void show_display(Viewer& viewer) {
  static constexpr const char* kNames[] = {"natural", "displacement", "area strain", "pressure"};
  if (viewer.now->scene && ImGui::BeginCombo("##color", kNames[int(viewer.display.color)])) {
    for (const SkinColor color : known_colors(*viewer.now->scene))
      if (ImGui::Selectable(kNames[int(color)], color == viewer.display.color)) viewer.display.color = color;
    ImGui::EndCombo();
  }
  bool wires = viewer.display.style == MeshStyle::kWires;
  if (ImGui::Checkbox("wires", &wires))
    viewer.display.style = wires ? MeshStyle::kWires : MeshStyle::kSurface;
  if (viewer.now->scene && !viewer.now->scene->sfem_bodies.empty()) {
    ImGui::SameLine();
    ImGui::Checkbox("patch", &viewer.display.patch);
  }
}

}  // namespace

void show_controls(Viewer& viewer) {
  if (!viewer.panels.controls) return;
  ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
  if (!ImGui::Begin("Turgor", nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return ImGui::End();
  show_running(viewer);
  ImGui::Separator();
  show_mouse(viewer);
  ImGui::Separator();
  show_display(viewer);
  ImGui::Separator();
  key_button(viewer, "Picture", "P");
  ImGui::SameLine();
  key_button(viewer, viewer.wants_video ? "End video" : "Video", "V");
  ImGui::SameLine();
  key_button(viewer, "Save scene", "S");
  ImGui::SameLine();
  key_button(viewer, "Save haptics", "H");
  ImGui::SameLine();
  key_button(viewer, "?", "?");
  ImGui::Checkbox("curves", &viewer.panels.curves);
  ImGui::SameLine();
  ImGui::Checkbox("parameters", &viewer.panels.parameters);
  if (viewer.now->scene && !viewer.now->scene->lattice_bodies.empty()) {
    ImGui::SameLine();
    ImGui::Checkbox("CT", &viewer.panels.ct);
  }
  ImGui::End();
}

void show_help(Viewer& viewer) {
  if (!viewer.panels.help) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
  if (!ImGui::Begin("Mouse and keys", &viewer.panels.help, ImGuiWindowFlags_AlwaysAutoResize))
    return ImGui::End();
  if (ImGui::BeginTable("help", 2)) {
    const auto row = [](const char* name, const char* sentence) {
      ImGui::TableNextColumn(), ImGui::TextUnformatted(name);
      ImGui::TableNextColumn(), ImGui::TextUnformatted(sentence);
    };
    for (const MouseHelp& entry : mouse_table()) row(entry.name, entry.sentence);
    for (const KeyHelp& entry : key_table()) row(entry.name, entry.sentence);
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace turgor
