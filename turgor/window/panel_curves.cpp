#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// Smallest number of the form 1, 2 or 5 times a power of ten that is not below `value`.
double round_above(double value) {
  if (!(value > 0)) return 1;
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (value <= digit * decade) return digit * decade;
  return 10 * decade;
}

/// Plots a curve over its whole x range, from 0 upwards (negative values are drawn on the axis), with labels
/// at the ends of the axes.
void plot(const char* name, const std::vector<ImVec2>& points, const char* x_unit, const char* y_unit) {
  const float text = ImGui::GetTextLineHeight();
  const ImVec2 corner = ImGui::GetCursorScreenPos(), size{ImGui::GetContentRegionAvail().x, 6 * text};
  ImGui::Dummy(size);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 low{corner.x, corner.y + size.y - text - 1}, high{corner.x + size.x, corner.y + text + 1};
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
  draw.AddLine(low, {high.x, low.y}, axis_color());
  draw.AddLine(low, {low.x, high.y}, axis_color());
  float x_low = 1e30f, x_high = -1e30f, y_most = 0;
  for (const ImVec2 p : points)
    x_low = std::min(x_low, p.x), x_high = std::max(x_high, p.x), y_most = std::max(y_most, p.y);
  const float y_high = float(round_above(y_most));
  draw.AddText(corner, ink, fmt::format("{}   to {:.3g} {}", name, y_high, y_unit).c_str());
  if (points.empty() || !(x_high > x_low)) return;
  std::vector<ImVec2> line;
  for (const ImVec2 p : points)
    line.push_back({low.x + (p.x - x_low) / (x_high - x_low) * (high.x - low.x),
                    low.y + std::max(0.0f, p.y) / y_high * (high.y - low.y)});
  draw.AddPolyline(line.data(), int(line.size()), curve_color(), 0, 1.5f);
  const bool begins_at_0 = std::abs(x_low) < 0.02f * (x_high - x_low);  // to the accuracy of the eye
  const std::string x_low_text = begins_at_0 ? "0" : fmt::format("{:.3g}", x_low);
  draw.AddText({low.x, low.y + 1}, ink, x_low_text.c_str());
  const std::string right = fmt::format("{:.4g} {}", x_high, x_unit);
  draw.AddText({high.x - ImGui::CalcTextSize(right.c_str()).x, low.y + 1}, ink, right.c_str());
}

void show_tool(const std::string& name, const std::vector<HapticSample>& haptic) {
  std::vector<ImVec2> over_time, over_depth, energy;
  for (const HapticSample& p : haptic) {
    over_time.push_back({float(p.time), float(p.force)});
    over_depth.push_back({float(1e3 * p.depth), float(p.force)});
    energy.push_back({float(p.time), float(1e3 * p.work)});
  }
  ImGui::Text("%s: %.3f N at %.1f mm", name.c_str(), haptic.back().force, 1e3 * haptic.back().depth);
  plot("force over time", over_time, "s", "N");
  plot("force over depth", over_depth, "mm", "N");
  plot("energy over time", energy, "s", "mJ");
}

}  // namespace

void show_curves(const Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  const bool any =
      std::any_of(now.haptic.begin(), now.haptic.end(), [](const auto& haptic) { return !haptic.empty(); });
  if (!any) return ImGui::TextWrapped("no tool has touched a body yet");
  for (std::size_t t = 0; t < now.haptic.size() && t < now.snapshot.tools.size(); t++)
    if (!now.haptic[t].empty()) show_tool(now.snapshot.tools[t].name, now.haptic[t]);
}

}  // namespace turgor
