#include <algorithm>

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
  const float fit = std::min(1.0f, ImGui::GetContentRegionAvail().x / float(std::max(1, image.width)));
  ImGui::Image(texture, {fit * float(image.width), fit * float(image.height)});
}

}  // namespace

void show_ct(Viewer& viewer, Sections& sections) {
  const SessionStatus& now = *viewer.now;
  ImGui::Checkbox("volume rendering", &viewer.display.volume);
  const float width = 0.6f * ImGui::GetContentRegionAvail().x;
  ImGui::SetNextItemWidth(width);
  choose("tissue", volume_presets(), viewer.display.preset);
  ImGui::SetNextItemWidth(width);
  choose("window", known_windows(), viewer.display.window);
  if (now.ct && !now.ct->ct.samples.empty()) {
    const Box box = bounding_box(now.ct->ct.grid);
    const Vec3d point = viewer.touched.value_or((box.low + box.high) * 0.5);
    renew(now.ct, point, viewer.display.window, sections);
    for (const ShownImage& image : sections.images) show_image(image);
    ImGui::TextWrapped("axial, coronal and sagittal, through the last touch or cut");
  }
}

}  // namespace turgor
