// Stitches by hand in the side panel.
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "turgor/sim/scene/scene_suture.hpp"
#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

const char* state_of(lattice::StitchPhase phase) {
  switch (phase) {
    case lattice::StitchPhase::kWaiting:
      return "waits";
    case lattice::StitchPhase::kPulled:
      return "is pulled";
    case lattice::StitchPhase::kKnotted:
      return "knotted";
    case lattice::StitchPhase::kPulledOut:
      return "tore out";
    case lattice::StitchPhase::kBroken:
      return "broke";
  }
  return "";
}

/// Thread and depth of the next stitch.
void show_thread_and_depth(StitchSettings& settings) {
  ImGui::SetNextItemWidth(9 * ImGui::GetFontSize());
  if (ImGui::BeginCombo("thread", settings.thread.c_str())) {
    for (const std::string& name : thread_names())
      if (ImGui::Selectable(name.c_str(), name == settings.thread)) settings.thread = name;
    ImGui::EndCombo();
  }
  auto depth = float(1e3 * settings.depth);
  ImGui::SetNextItemWidth(-9 * ImGui::GetFontSize());
  if (ImGui::SliderFloat("##stitch depth", &depth, float(1e3 * kLeastStitchDepth),
                         float(1e3 * kMostStitchDepth), "", ImGuiSliderFlags_Logarithmic))
    settings.depth = std::clamp(1e-3 * double(depth), kLeastStitchDepth, kMostStitchDepth);
  ImGui::SameLine();
  ImGui::Text("depth %.1f mm", 1e3 * settings.depth);
}

/// Pull of the selected stitch and of the next ones.
void show_pull(Viewer& viewer) {
  StitchSettings& settings = viewer.stitches;
  const HandStitch* stitch = selected_stitch(viewer);
  if (ImGui::Checkbox("pull until the lips meet", &settings.until_closed) && stitch)
    tighten(viewer, *stitch, settings.until_closed ? std::nullopt : std::optional(settings.tension));
  ImGui::BeginDisabled(settings.until_closed);
  auto tension = float(settings.tension);
  ImGui::SetNextItemWidth(-9 * ImGui::GetFontSize());
  if (ImGui::SliderFloat("##tension", &tension, float(kLeastTension), float(kMostTension), "",
                         ImGuiSliderFlags_Logarithmic)) {
    settings.tension = std::clamp(double(tension), kLeastTension, kMostTension);
    if (stitch) tighten(viewer, *stitch, settings.tension);
  }
  ImGui::SameLine();
  ImGui::Text("tension %.2f N", settings.tension);
  ImGui::EndDisabled();
}

}  // namespace

std::string stitch_text(const HandStitch& stitch) {
  return fmt::format("{:.2f} N, gapes {:.1f} mm, {}", stitch.tension, 1e3 * std::max(0.0, stitch.gape),
                     state_of(stitch.phase));
}

void show_stitches(Viewer& viewer) {
  if (viewer.mode == MouseMode::kSuture) {
    show_thread_and_depth(viewer.stitches);
    show_pull(viewer);
  }
  const std::vector<HandStitch>& stitches = viewer.now->stitches;
  const HandStitch* selected = selected_stitch(viewer);
  for (std::size_t n = 0; n < stitches.size(); n++) {
    const std::string text = fmt::format("stitch {}: {}", n + 1, stitch_text(stitches[n]));
    const bool is_selected = viewer.mode == MouseMode::kSuture && &stitches[n] == selected;
    if (ImGui::Selectable(text.c_str(), is_selected)) viewer.stitches.selected = int(n);
  }
}

}  // namespace turgor
