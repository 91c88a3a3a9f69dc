// The dialog for files, and the question about unsaved cuts and changes.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

void center_next_window(ImVec2 size) {
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Always, {0.5f, 0.5f});
  if (size.x > 0) ImGui::SetNextWindowSize(size);
}

constexpr ImGuiWindowFlags kModal =
    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings;

/// Entries of the folder. True: one was chosen by a double click.
bool show_entries(FileDialog& dialog) {
  const float below = 2.6f * ImGui::GetFrameHeightWithSpacing();
  bool is_chosen = false;
  fs::path entered;
  if (ImGui::BeginChild("entries", {0, -below}, true)) {
    if (!dialog.list.problem.empty()) ImGui::TextColored(failure_color(), "%s", dialog.list.problem.c_str());
    for (const FolderEntry& entry : dialog.list.entries) {
      const std::string label = entry.is_folder ? entry.name + "/" : entry.name;
      if (!ImGui::Selectable(label.c_str(), entry.name == dialog.name, ImGuiSelectableFlags_AllowDoubleClick))
        continue;
      if (entry.is_folder && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left))
        entered = dialog.folder / entry.name;
      else
        dialog.name = entry.name, is_chosen = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    }
  }
  ImGui::EndChild();
  if (!entered.empty()) enter_folder(entered, dialog);
  return is_chosen;
}

/// The path of the folder, with a button for each of its parents.
void show_folder(FileDialog& dialog) {
  fs::path entered, path;
  int n = 0;
  for (const fs::path& name : dialog.folder) {
    if (name.empty()) continue;
    path /= name;
    const float width = ImGui::CalcTextSize(name.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (n++ > 0) {
      ImGui::SameLine(0, 2);
      if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
    }
    if (ImGui::Button((name.string() + "##" + std::to_string(n)).c_str())) entered = path;
  }
  if (!entered.empty()) enter_folder(entered, dialog);
}

}  // namespace

void show_file_dialog(Viewer& viewer) {
  FileDialog& dialog = viewer.document.dialog;
  const bool opens = dialog.purpose == FileDialog::Purpose::kOpen;
  const char* title = opens ? "Open a scene or a cut" : "Save the scene as";
  if (dialog.is_open && !ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  center_next_window({0.7f * screen.x, 0.75f * screen.y});
  if (!ImGui::BeginPopupModal(title, nullptr, kModal)) return;
  show_folder(dialog);
  bool is_confirmed = show_entries(dialog);
  ImGui::SetNextItemWidth(-1);
  is_confirmed |= ImGui::InputTextWithHint("##name", opens ? "NAME.toml or NAME.mrk.json" : "NAME.toml",
                                           &dialog.name, ImGuiInputTextFlags_EnterReturnsTrue);
  is_confirmed |= ImGui::Button(opens ? "Open" : "Save");
  ImGui::SameLine();
  if (ImGui::Button("Cancel")) dialog.is_open = false;
  if (is_confirmed)
    if (const auto file = confirm(dialog)) opens ? open_file(viewer, *file) : save_new(viewer, *file);
  if (!dialog.is_open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void show_question(Viewer& viewer) {
  Document& document = viewer.document;
  constexpr const char* kTitle = "Unsaved cuts or changes";
  if (document.leaving != Leaving::kNothing && !ImGui::IsPopupOpen(kTitle)) ImGui::OpenPopup(kTitle);
  center_next_window({});
  if (!ImGui::BeginPopupModal(kTitle, nullptr, kModal | ImGuiWindowFlags_AlwaysAutoResize)) return;
  ImGui::TextUnformatted(document.leaving == Leaving::kRestart || document.leaving == Leaving::kReload
                             ? "A restart removes the cuts that you made. Save them first?"
                             : "The scene has cuts or changes that are not saved. Save them first?");
  ImGui::Spacing();
  if (ImGui::Button(document.is_example ? "Save as…" : "Save")) {
    save(viewer);
    if (!document.is_example && !has_unsaved_edits(viewer))
      leave(viewer);
    else
      document.leaving = Leaving::kNothing;
  }
  ImGui::SameLine();
  if (ImGui::Button("Don't save")) leave(viewer);
  ImGui::SameLine();
  if (ImGui::Button("Cancel")) document.leaving = Leaving::kNothing;
  if (document.leaving == Leaving::kNothing) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

}  // namespace turgor
