#include <algorithm>
#include <utility>

#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

void list(GalleryPictures& gallery) {
  if (std::exchange(gallery.is_listed, true)) return;
  gallery.scenes = list_scenes(scene_folder());
  for (const GalleryScene& scene : gallery.scenes) {
    gallery.pictures.push_back(nullptr);
    const Result<Image> picture = read_png(scene.picture);
    if (!picture) continue;
    gallery.pictures.back() = std::make_unique<ShownImage>();
    gallery.pictures.back()->show(*picture);
  }
}

/// A picture with its title and sentence. True: it was clicked.
bool show_scene(const GalleryScene& scene, const ShownImage* picture, float width) {
  ImGui::PushID(scene.title.c_str());
  ImGui::BeginGroup();
  const ImVec2 size{width, 0.6f * width};
  bool is_chosen = false;
  if (picture) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): ImGui keeps OpenGL's number as a pointer
    is_chosen = ImGui::ImageButton(reinterpret_cast<ImTextureID>(std::intptr_t(picture->texture)), size,
                                   {0, 0}, {1, 1}, 0);
  } else {
    is_chosen = ImGui::Button(scene.title.c_str(), size);
  }
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + width);
  ImGui::TextUnformatted(scene.title.c_str());
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextUnformatted(scene.sentence.c_str());
  ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
  ImGui::EndGroup();
  ImGui::PopID();
  return is_chosen;
}

/// Scenes that were opened before.
void show_recent_scenes(Viewer& viewer) {
  const std::vector<std::filesystem::path> recent = viewer.settings.recent;  // opening one reorders them
  if (recent.empty()) return;
  ImGui::TextUnformatted("Recent");
  for (const std::filesystem::path& file : recent)
    if (ImGui::Selectable(file.string().c_str())) open_file(viewer, file);
  ImGui::Spacing();
}

}  // namespace

void show_gallery(Viewer& viewer, GalleryPictures& gallery) {
  if (!viewer.shows_gallery) return;
  list(gallery);
  const Area& area = viewer.area;
  ImGui::SetNextWindowPos({float(area.x), float(area.y)});
  ImGui::SetNextWindowSize({float(area.width), float(area.height)});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_AlwaysVerticalScrollbar;
  if (!ImGui::Begin("gallery", nullptr, kFlags & ~ImGuiWindowFlags_NoScrollbar)) return ImGui::End();
  if (ImGui::Button("Open a file…")) show_open_dialog(viewer);
  if (viewer.now->scene) {
    ImGui::SameLine();
    if (ImGui::Button("Back to the scene")) viewer.shows_gallery = false;
  }
  ImGui::Spacing();
  show_recent_scenes(viewer);
  ImGui::TextUnformatted(gallery.scenes.empty() ? "No folder of scenes was found: TURGOR_SCENES can name one."
                                                : "Scenes that come with Turgor");
  const float space = ImGui::GetStyle().ItemSpacing.x, available = ImGui::GetContentRegionAvail().x;
  const int columns = std::max(1, int(available / (13 * ImGui::GetFontSize() + space)));
  const float width = available / float(columns) - space;
  if (ImGui::BeginTable("scenes", columns)) {
    for (std::size_t n = 0; n < gallery.scenes.size(); n++) {
      ImGui::TableNextColumn();
      if (show_scene(gallery.scenes[n], gallery.pictures[n].get(), width))
        open_example(viewer, gallery.scenes[n].file);
      ImGui::Spacing();
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace turgor
