#include "turgor/window/appearance.hpp"

#include <cmath>
#include <string>

#include "turgor/view/text.hpp"

namespace turgor {

namespace {

bool is_light() { return ImGui::GetStyleColorVec4(ImGuiCol_WindowBg).x > 0.5f; }

}  // namespace

void set_font(float text_size, WindowScale scale) {
  static constexpr ImWchar kLetters[] = {0x20, 0xFF, 0x370, 0x3FF, 0x2010, 0x22FF, 0};
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  ImFontConfig font;
  font.SizePixels = std::round(text_size * scale.monitor);
  const std::string file = font_file();
  if (file.empty())
    io.Fonts->AddFontDefault(&font);
  else
    io.Fonts->AddFontFromFileTTF(file.c_str(), font.SizePixels, nullptr, kLetters);
  io.FontGlobalScale = 1 / scale.framebuffer;
}

void set_appearance(const Appearance& appearance, WindowScale scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  if (appearance.theme == Theme::kLight)
    ImGui::StyleColorsLight();
  else
    ImGui::StyleColorsDark();
  style.FrameBorderSize = appearance.theme == Theme::kLight ? 1 : 0;  // else white boxes vanish on gray
  style.WindowRounding = 0, style.FrameRounding = 3, style.GrabRounding = 3, style.PopupRounding = 3;
  style.FramePadding = {7, 4}, style.ItemSpacing = {8, 6}, style.WindowPadding = {10, 10};
  style.ScaleAllSizes(scale.units() * appearance.text_size / Appearance().text_size);
  style.Colors[ImGuiCol_WindowBg].w = 1;
  style.Colors[ImGuiCol_PlotHistogram] = style.Colors[ImGuiCol_SliderGrab];  // of progress bars
}

ImVec4 failure_color() { return is_light() ? ImVec4{0.75f, 0.05f, 0, 1} : ImVec4{1, 0.45f, 0.35f, 1}; }
ImVec4 success_color() { return is_light() ? ImVec4{0.05f, 0.4f, 0.1f, 1} : ImVec4{0.65f, 0.9f, 0.65f, 1}; }
ImVec4 plain_color() { return ImGui::GetStyleColorVec4(ImGuiCol_Text); }
ImU32 axis_color() { return ImGui::GetColorU32(ImGuiCol_TextDisabled); }
ImU32 curve_color() { return is_light() ? IM_COL32(176, 92, 0, 255) : IM_COL32(250, 204, 70, 255); }

}  // namespace turgor
