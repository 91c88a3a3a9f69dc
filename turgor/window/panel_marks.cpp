#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

constexpr ImU32 kInk = IM_COL32(236, 239, 242, 255), kShade = IM_COL32(0, 0, 0, 160),
                kLine = IM_COL32(255, 90, 70, 255), kWind = IM_COL32(120, 190, 255, 255),
                kPatch = IM_COL32(60, 220, 200, 200);

std::optional<ImVec2> pixel_of(const Viewer& viewer, Vec3d point) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto position = project(viewer.camera, point, viewer.aspect);
  if (!position) return std::nullopt;
  return ImVec2{float(0.5 * (1 + position->x)) * size.x, float(0.5 * (1 - position->y)) * size.y};
}

void write(ImDrawList& draw, ImVec2 at, const std::string& text) {
  draw.AddText({at.x + 1, at.y + 1}, kShade, text.c_str());
  draw.AddText(at, kInk, text.c_str());
}

void draw_line(ImDrawList& draw, const Viewer& viewer, const DrawnLine& line, ImU32 color) {
  const auto from = pixel_of(viewer, line.from), to = pixel_of(viewer, line.to);
  if (!from || !to) return;
  draw.AddLine(*from, *to, color, 3);
  draw.AddCircleFilled(*to, 5, color);
}

/// Draws edges of the triangles that face the eye.
void draw_patch(ImDrawList& draw, const Viewer& viewer, const TriMesh& patch) {
  std::vector<std::optional<ImVec2>> pixels;
  for (const Vec3 x : patch.vertices) pixels.push_back(pixel_of(viewer, Vec3d(x)));
  for (const Int3 t : patch.triangles) {
    const auto x = [&patch](int v) { return Vec3d(patch.vertices[std::size_t(v)]); };
    if (dot(cross(x(t.y) - x(t.x), x(t.z) - x(t.x)), viewer.camera.eye - x(t.x)) <= 0) continue;
    const auto &a = pixels[std::size_t(t.x)], &b = pixels[std::size_t(t.y)], &c = pixels[std::size_t(t.z)];
    if (a && b && c) draw.AddTriangle(*a, *b, *c, kPatch);
  }
}

void draw_legend(ImDrawList& draw, const ColorScale& scale) {
  constexpr int kSteps = 32;
  constexpr float kWidth = 16, kHeight = 180;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const ImVec2 corner{size.x - 100, size.y - kHeight - 90};
  for (int n = 0; n < kSteps; n++) {
    const Rgb c = map_color(1 - (float(n) + 0.5f) / kSteps);
    const float top = corner.y + kHeight * float(n) / kSteps;
    draw.AddRectFilled({corner.x, top}, {corner.x + kWidth, top + kHeight / kSteps},
                       IM_COL32(c.r, c.g, c.b, 255));
  }
  write(draw, {corner.x + kWidth + 6, corner.y - 8}, fmt::format("{:.3g}", scale.high * scale.factor));
  write(draw, {corner.x + kWidth + 6, corner.y + kHeight - 8},
        fmt::format("{:.3g}", scale.low * scale.factor));
  const float width = ImGui::CalcTextSize(scale.label.c_str()).x;
  write(draw, {size.x - width - 12, corner.y - 30}, scale.label);
}

}  // namespace

void show_marks(const Viewer& viewer, const WorldPicture& picture) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  for (const PictureLabel& label : picture.labels)
    if (const auto at = pixel_of(viewer, label.position)) write(draw, *at, label.text);
  if (viewer.display.patch)
    for (const BodySnapshot& body : viewer.now->snapshot.bodies) draw_patch(draw, viewer, body.patch);
  if (viewer.cut) draw_line(draw, viewer, *viewer.cut, kLine);
  if (viewer.wind) draw_line(draw, viewer, *viewer.wind, kWind);
  if (picture.has_scale) draw_legend(draw, picture.scale);
}

}  // namespace turgor
