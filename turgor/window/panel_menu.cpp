#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/gallery.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// A menu item with the effect of a key.
void key_item(Viewer& viewer, const char* label, const char* key, bool is_enabled = true,
              bool is_checked = false) {
  if (ImGui::MenuItem(label, key, is_checked, is_enabled)) act(viewer, key);
}

void show_recent(Viewer& viewer) {
  const std::vector<std::filesystem::path> recent = viewer.settings.recent;  // opening one reorders them
  if (!ImGui::BeginMenu("Open recent", !recent.empty())) return;
  for (const std::filesystem::path& file : recent)
    if (ImGui::MenuItem(file.string().c_str())) open_file(viewer, file);
  ImGui::Separator();
  if (ImGui::MenuItem("Forget all")) viewer.settings.recent.clear();
  ImGui::EndMenu();
}

void show_file_menu(Viewer& viewer) {
  if (!ImGui::BeginMenu("File")) return;
  const bool has_scene = viewer.now->scene != nullptr;
  key_item(viewer, "Open…", "Ctrl+O");
  show_recent(viewer);
  if (ImGui::MenuItem("Gallery", nullptr, viewer.shows_gallery)) viewer.shows_gallery = !viewer.shows_gallery;
  key_item(viewer, "Reload", "R", has_scene);
  ImGui::Separator();
  key_item(viewer, "Save", "Ctrl+S", has_scene);
  key_item(viewer, "Save as…", "Ctrl+Shift+S", has_scene);
  key_item(viewer, "Save a numbered copy", "S", has_scene);
  ImGui::Separator();
  key_item(viewer, "Quit", "Ctrl+Q");
  ImGui::EndMenu();
}

void show_edit_menu(Viewer& viewer) {
  if (!ImGui::BeginMenu("Edit")) return;
  const auto label = [](const char* what, const std::string& edit) {
    return edit.empty() ? std::string(what) : fmt::format("{} {}", what, edit);
  };
  const SessionStatus& now = *viewer.now;
  key_item(viewer, label("Undo", now.undo).c_str(), "Ctrl+Z", !now.undo.empty());
  key_item(viewer, label("Redo", now.redo).c_str(), "Ctrl+Shift+Z", !now.redo.empty());
  ImGui::EndMenu();
}

void show_appearance(Viewer& viewer) {
  Appearance& look = viewer.settings.appearance;
  if (ImGui::MenuItem("Dark theme", nullptr, look.theme == Theme::kDark)) look.theme = Theme::kDark;
  if (ImGui::MenuItem("Light theme", nullptr, look.theme == Theme::kLight)) look.theme = Theme::kLight;
  if (ImGui::MenuItem("Larger text", nullptr, false, look.text_size < kLargestText)) look.text_size += 2;
  if (ImGui::MenuItem("Smaller text", nullptr, false, look.text_size > kSmallestText)) look.text_size -= 2;
}

void show_view_menu(Viewer& viewer) {
  if (!ImGui::BeginMenu("View")) return;
  static constexpr const char* kViews[][2] = {
      {"Front", "1"}, {"Back", "2"}, {"Patient's right", "3"}, {"Patient's left", "4"},
      {"Head", "5"},  {"Feet", "6"}, {"Whole scene", "0"}};
  for (const auto& [label, key] : kViews) key_item(viewer, label, key);
  ImGui::Separator();
  key_item(viewer, "Side panel", "Tab", true, viewer.panels.controls);
  show_appearance(viewer);
  ImGui::EndMenu();
}

void show_output_menu(Viewer& viewer) {
  if (!ImGui::BeginMenu("Record")) return;
  key_item(viewer, "Save a picture", "P");
  key_item(viewer, viewer.wants_video ? "Stop the video" : "Start a video", "V");
  ImGui::MenuItem("Without panels", nullptr, &viewer.records_picture_only);
  ImGui::Separator();
  key_item(viewer, "Save the haptic recording", "H", viewer.now->is_haptic);
  ImGui::EndMenu();
}

}  // namespace

void show_menu(Viewer& viewer) {
  if (!ImGui::BeginMainMenuBar()) return;
  show_file_menu(viewer);
  show_edit_menu(viewer);
  show_view_menu(viewer);
  show_output_menu(viewer);
  if (ImGui::BeginMenu("Help")) {
    key_item(viewer, "Mouse and keys", "?", true, viewer.panels.help);
    ImGui::EndMenu();
  }
  viewer.menu_height = double(ImGui::GetWindowHeight());
  ImGui::EndMainMenuBar();
}

}  // namespace turgor
