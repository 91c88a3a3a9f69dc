#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// A button with the effect of a key, wide enough for another label that it has at other times.
void key_button(Viewer& viewer, const char* label, const char* key, const char* widest = nullptr) {
  const float padding = 2 * ImGui::GetStyle().FramePadding.x;
  if (ImGui::Button(label, {widest ? ImGui::CalcTextSize(widest).x + padding : 0, 0})) act(viewer, key);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("key: %s", key);
}

void show_running(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  ImGui::BeginDisabled(now.scene == nullptr);
  key_button(viewer, now.plays ? "Pause##play" : "Play##play", "Space", "Pause");
  ImGui::SameLine();
  key_button(viewer, "Step", ".");
  ImGui::SameLine();
  key_button(viewer, "Reset", "Backspace");
  key_button(viewer, "Slower", "-");
  ImGui::SameLine();
  key_button(viewer, "Faster", "+");
  ImGui::SameLine();
  ImGui::Text("%.3g × real time", now.pace);
  ImGui::EndDisabled();
}

void show_mouse(Viewer& viewer) {
  int mode = int(viewer.mode);
  int n = 0;
  for (const char* name : {"touch", "grab", "cut", "suture", "wind"}) {
    if (n != 0 && n != 3) ImGui::SameLine();
    if (ImGui::RadioButton(name, &mode, n++)) viewer.stitch.reset();
  }
  viewer.mode = MouseMode(mode);
  if (viewer.touching && !viewer.touching->needle) ImGui::Text("%.1f mm deep", 1e3 * viewer.touching->depth);
}

/// Depth, progress and result of cuts.
void show_cut(Viewer& viewer) {
  if (viewer.mode == MouseMode::kCut) {
    auto depth = float(1e3 * viewer.cut_depth);
    ImGui::SetNextItemWidth(-9 * ImGui::GetFontSize());
    if (ImGui::SliderFloat("##depth", &depth, float(1e3 * kLeastDepth), float(1e3 * kMostDepth), "",
                           ImGuiSliderFlags_Logarithmic))
      viewer.cut_depth = std::clamp(1e-3 * double(depth), kLeastDepth, kMostDepth);
    ImGui::SameLine();
    ImGui::Text("depth %.0f mm", 1e3 * viewer.cut_depth);  // beside the slider, whose handle would cover it
  }
  const CutResult& result = viewer.now->cut_result;
  if (result.cut < 0) return;
  if (!result.is_measured) {
    ImGui::Text("cutting %.0f %%", 100 * result.done);
    ImGui::ProgressBar(float(result.done), {-1, 0.5f * ImGui::GetTextLineHeight()}, "");
    return;
  }
  ImGui::TextWrapped("%s", cut_text(result).c_str());
}

void show_display(Viewer& viewer) {
  static constexpr const char* kNames[] = {"natural", "displacement", "area strain", "pressure",
                                           "largest stretch"};
  if (viewer.now->scene && ImGui::BeginCombo("##color", kNames[int(viewer.display.color)])) {
    for (const SkinColor color : known_colors(*viewer.now->scene))
      if (ImGui::Selectable(kNames[int(color)], color == viewer.display.color)) viewer.display.color = color;
    ImGui::EndCombo();
  }
  bool wires = viewer.display.style == MeshStyle::kWires;
  if (ImGui::Checkbox("wires", &wires))
    viewer.display.style = wires ? MeshStyle::kWires : MeshStyle::kSurface;
  ImGui::SameLine();
  bool cuts = viewer.display.cutaway.has_value();
  if (ImGui::Checkbox("cut away", &cuts)) act(viewer, "A");
  if (viewer.now->scene && !viewer.now->scene->sfem_bodies.empty()) {
    ImGui::SameLine();
    ImGui::Checkbox("patch", &viewer.display.patch);
  }
  if (!viewer.now->snapshot.organ_forces.empty())
    ImGui::Checkbox("forces", &viewer.display.organ_forces);  // a line has room for three
}

/// Heading of a group, and its table.
void begin_group(const char* name) {
  ImGui::Spacing();
  ImGui::TextColored(success_color(), "%s", name);
  ImGui::BeginTable(name, 2, ImGuiTableFlags_SizingStretchProp);
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed, 8.5f * ImGui::GetFontSize());
  ImGui::TableSetupColumn("sentence");
}
void help_row(const char* name, const char* sentence) {
  ImGui::TableNextColumn(), ImGui::TextWrapped("%s", name);
  ImGui::TableNextColumn(), ImGui::TextWrapped("%s", sentence);
}

}  // namespace

std::string cut_text(const CutResult& result) {
  return fmt::format("last cut: {:.1f} mm long, {:.1f} mm deep, gapes {:.1f} mm (mean {:.1f} mm)",
                     1e3 * result.length, 1e3 * result.depth, 1e3 * result.gape_max, 1e3 * result.gape_mean);
}

void show_controls(Viewer& viewer) {
  show_running(viewer);
  ImGui::Separator();
  show_mouse(viewer);
  show_cut(viewer);
  show_stitches(viewer);
  show_needle(viewer);
  ImGui::Separator();
  show_display(viewer);
  ImGui::Separator();
  key_button(viewer, "Picture", "P");
  ImGui::SameLine();
  key_button(viewer, viewer.wants_video ? "End video" : "Video", "V");
}

void show_help(Viewer& viewer) {
  if (!viewer.panels.help) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(0.95f * size.x, 58 * ImGui::GetFontSize()), 0}, ImGuiCond_Appearing);
  ImGui::SetNextWindowSizeConstraints({0, 0}, {size.x, 0.95f * size.y});
  if (!ImGui::Begin("Mouse and keys", &viewer.panels.help, ImGuiWindowFlags_NoSavedSettings))
    return ImGui::End();
  if (ImGui::BeginTable("groups", 2)) {
    ImGui::TableNextColumn();
    begin_group("Mouse on the picture");
    for (const MouseHelp& entry : mouse_table()) help_row(entry.name, entry.sentence);
    const char* group = "";
    const std::span<const KeyHelp> keys = key_table();
    for (std::size_t n = 0; n < keys.size(); n++) {
      if (keys[n].group != group) {
        ImGui::EndTable();
        if (n > 0 && std::string_view(keys[n].group) == "View") ImGui::TableNextColumn();
        begin_group(group = keys[n].group);
      }
      help_row(keys[n].name, keys[n].sentence);
    }
    ImGui::EndTable();
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace turgor
