// A needle in use: depth, force and the layer at its tip.
#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

std::string needle_text(const Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  for (std::size_t t = 0; t < now.haptic.size() && t < now.layers.size(); t++) {
    const bool is_used = viewer.touching && viewer.touching->needle && viewer.touching->tool.tool == int(t);
    if (!needle_length(*now.scene, int(t)) || now.haptic[t].empty()) continue;
    const HapticSample& sample = now.haptic[t].back();
    if (!is_used && !(sample.needle.inserted > 0)) continue;
    const std::string layer = now.layers[t].empty() ? "outside" : "in " + now.layers[t];
    return fmt::format(
        "needle: {:.1f} mm deep, {:.2f} N, tip {}\ncutting {:.2f} N, spreading {:.2f} N,\nfriction {:.2f} N",
        1e3 * sample.needle.inserted, sample.force, layer, sample.needle.cutting, sample.needle.spreading,
        sample.needle.friction);
  }
  return {};
}

void show_needle(Viewer& viewer) {
  const std::string text = viewer.now->scene ? needle_text(viewer) : "";
  if (text.empty()) return;
  ImGui::TextWrapped("%s", text.c_str());
  if (!viewer.touching || !viewer.touching->needle) return;
  if (ImGui::Button("Withdraw")) withdraw_needle(viewer);
  ImGui::SameLine();
  ImGui::Text("PgUp, PgDn: 1 mm");
}

}  // namespace turgor
