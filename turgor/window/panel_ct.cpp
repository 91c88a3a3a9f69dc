#include <imgui.h>

#include "turgor/view/transfer.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

void choose(const char* name, const std::vector<std::string>& names, std::string& chosen) {
  if (!ImGui::BeginCombo(name, chosen.c_str())) return;
  for (const std::string& one : names)
    if (ImGui::Selectable(one.c_str(), one == chosen)) chosen = one;
  ImGui::EndCombo();
}

/// Rows of the texture start at the top, as ImGui expects.
void show_image(const ShownImage& image) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): ImGui keeps OpenGL's number as a pointer
  const auto texture = reinterpret_cast<ImTextureID>(std::intptr_t(image.texture));
  ImGui::Image(texture, {float(image.width), float(image.height)});
}

}  // namespace

void show_ct(Viewer& viewer, Sections& sections) {
  const SessionStatus& now = *viewer.now;
  if (!viewer.panels.ct || !now.scene || now.scene->lattice_bodies.empty()) return;
  ImGui::SetNextWindowPos({8, 300}, ImGuiCond_FirstUseEver);
  if (!ImGui::Begin("Deformed CT", &viewer.panels.ct, ImGuiWindowFlags_AlwaysAutoResize)) return ImGui::End();
  ImGui::Checkbox("volume rendering", &viewer.display.volume);
  ImGui::SetNextItemWidth(140);
  choose("tissue", volume_presets(), viewer.display.preset);
  ImGui::SetNextItemWidth(140);
  choose("window", known_windows(), viewer.display.window);
  if (now.ct && !now.ct->ct.samples.empty()) {
    const Box box = bounding_box(now.ct->ct.grid);
    const Vec3d point = viewer.touched.value_or((box.low + box.high) * 0.5);
    renew(now.ct, point, viewer.display.window, sections);
    for (const ShownImage& image : sections.images) {
      show_image(image);
      ImGui::SameLine();
    }
    ImGui::NewLine();
    ImGui::TextUnformatted("axial, coronal and sagittal, through the last touch or cut");
  }
  ImGui::End();
}

}  // namespace turgor
