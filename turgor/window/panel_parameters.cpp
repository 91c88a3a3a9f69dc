#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

std::string tip_of(const Parameter& parameter) {
  const std::string limits = limits_text(parameter.key.allowed);
  return fmt::format("{}\n{}{}{}\n{}{}{}", parameter.key.path, parameter.key.unit, limits.empty() ? "" : ", ",
                     limits, parameter.key.meaning,
                     parameter.waits.empty() ? "" : "\nafter Reset: ", parameter.waits);
}

/// A slider's state: being moved, or released.
struct Turned {
  bool moved = false, let_go = false;
};
Turned turn(Parameter& parameter) {
  const Allowed& allowed = parameter.key.allowed;
  const double largest =
      std::max({std::abs(parameter.value[0]), std::abs(parameter.value[1]), std::abs(parameter.value[2])});
  const float speed = float(std::max(largest, 0.01 * (parameter.key.is_whole ? 100 : 1)) / 100);
  const char* format = parameter.key.is_whole ? "%.0f" : "%.4g";
  Turned turned;
  turned.moved = ImGui::DragScalarN(parameter.key.path.c_str(), ImGuiDataType_Double, parameter.value.data(),
                                    parameter.count, speed, nullptr, nullptr, format);
  for (int n = 0; n < parameter.count; n++)
    parameter.value[std::size_t(n)] = limited(allowed, parameter.value[std::size_t(n)]);
  turned.let_go = ImGui::IsItemDeactivatedAfterEdit();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip_of(parameter).c_str());
  return turned;
}

void show_list(Viewer& viewer, bool live) {
  for (Parameter& parameter : viewer.parameters) {
    if (parameter.waits.empty() != live) continue;
    const Turned turned = turn(parameter);
    if (!(live ? turned.moved : turned.let_go)) continue;
    viewer.session.request(ChangeRequest{parameter.key.path, value_text(parameter)});
    viewer.message = fmt::format("{} = {} {}{}{}", parameter.key.path, value_text(parameter),
                                 parameter.key.unit, live ? "" : ": after Reset, because ", parameter.waits);
  }
}

}  // namespace

void show_parameters(Viewer& viewer) {
  if (!viewer.panels.parameters) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({8, 240}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({460, size.y - 330}, ImGuiCond_FirstUseEver);
  if (!ImGui::Begin("Parameters", &viewer.panels.parameters)) return ImGui::End();
  ImGui::PushItemWidth(150);
  ImGui::TextUnformatted("immediate");
  show_list(viewer, true);
  ImGui::Separator();
  ImGui::TextUnformatted("after Reset");
  show_list(viewer, false);
  ImGui::PopItemWidth();
  ImGui::End();
}

}  // namespace turgor
