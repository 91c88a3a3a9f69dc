#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

std::string tip_of(const Parameter& parameter) {
  return fmt::format("{} [{}]\n{}\ndefault {}{}{}", parameter.key.path, unit_and_range(parameter),
                     parameter.key.meaning, parameter.key.fallback,
                     parameter.waits.empty() ? "" : "\nafter a restart: ", parameter.waits);
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
  const char* number = parameter.key.is_whole ? "%.0f" : "%.4g";
  const std::string format =
      parameter.count == 1 ? fmt::format("{} {}", number, parameter.key.unit) : std::string(number);
  Turned turned;
  turned.moved = ImGui::DragScalarN("##value", ImGuiDataType_Double, parameter.value.data(), parameter.count,
                                    speed, nullptr, nullptr, format.c_str());
  for (int n = 0; n < parameter.count; n++)
    parameter.value[std::size_t(n)] = limited(allowed, parameter.value[std::size_t(n)]);
  turned.let_go = ImGui::IsItemDeactivatedAfterEdit();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip_of(parameter).c_str());
  return turned;
}

void change(Viewer& viewer, const Parameter& parameter, const std::optional<std::string>& value) {
  viewer.session.request(ChangeRequest{parameter.key.path, value});
  viewer.message = fmt::format("{} = {}{}{}", parameter.key.path, value.value_or("as in the scene"),
                               parameter.waits.empty() ? "" : " after a restart, because ", parameter.waits);
}

/// Name, unit and range; below them the value, and a button that takes back its changes.
void show_parameter(Viewer& viewer, Parameter& parameter, std::size_t owner_length) {
  ImGui::PushID(parameter.key.path.c_str());
  ImGui::TextWrapped("%s", parameter.key.path.substr(owner_length + 1).c_str());
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextWrapped("%s%s", unit_and_range(parameter).c_str(),
                     parameter.waits.empty() ? "" : "; after a restart");
  ImGui::PopStyleColor();
  const float reset = ImGui::CalcTextSize("Reset").x + 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(-reset - ImGui::GetStyle().ItemSpacing.x);
  const Turned turned = turn(parameter);
  if (parameter.waits.empty() ? turned.moved : turned.let_go)
    change(viewer, parameter, value_text(parameter));
  ImGui::SameLine();
  if (!parameter.is_changed) ImGui::BeginDisabled();
  if (ImGui::Button("Reset")) change(viewer, parameter, parameter.opened);
  if (!parameter.is_changed) ImGui::EndDisabled();
  ImGui::PopID();
}

bool contains(const Parameter& parameter, const std::string& text) {
  return text.empty() || parameter.key.path.find(text) != std::string::npos ||
         parameter.key.meaning.find(text) != std::string::npos;
}

/// One header per body, tool or incision, with its parameters that act at once first.
void show_owner(Viewer& viewer, const std::string& owner) {
  const bool is_searching = !viewer.parameter_filter.empty();
  if (is_searching) ImGui::SetNextItemOpen(true, ImGuiCond_Always);
  if (!ImGui::TreeNode(owner.c_str())) return;
  for (Parameter& parameter : viewer.parameters)
    if (owner_of(parameter) == owner && contains(parameter, viewer.parameter_filter))
      show_parameter(viewer, parameter, owner.size());
  ImGui::TreePop();
}

/// Lists the parameters again after undo, reset and other changes, unless one is being moved.
void refresh(Viewer& viewer) {
  if (viewer.listed == viewer.now->scene || ImGui::IsAnyItemActive()) return;
  viewer.listed = viewer.now->scene;
  viewer.parameters = list_parameters(*viewer.listed, viewer.document.opened_overrides);
}

}  // namespace

void show_parameters(Viewer& viewer) {
  refresh(viewer);
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##filter", "search", &viewer.parameter_filter);
  std::vector<std::string> owners;
  for (const Parameter& parameter : viewer.parameters) {
    const std::string owner = owner_of(parameter);
    if (contains(parameter, viewer.parameter_filter) &&
        std::find(owners.begin(), owners.end(), owner) == owners.end())
      owners.push_back(owner);
  }
  for (const std::string& owner : owners) show_owner(viewer, owner);
}

}  // namespace turgor
