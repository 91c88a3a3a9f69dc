#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

constexpr ImU32 kInk = IM_COL32(236, 239, 242, 255), kShade = IM_COL32(0, 0, 0, 160),
                kLine = IM_COL32(255, 90, 70, 255), kWindLine = IM_COL32(120, 190, 255, 255),
                kPatch = IM_COL32(60, 220, 200, 200), kBlade = IM_COL32(255, 90, 70, 70),
                kBladeEdge = IM_COL32(255, 160, 140, 200), kThread = IM_COL32(70, 120, 255, 255);

std::optional<ImVec2> pixel_of(const Viewer& viewer, Vec3d point) {
  const Area& area = viewer.area;
  const auto position = project(viewer.camera, point, viewer.aspect);
  if (!position) return std::nullopt;
  return ImVec2{float(area.x + 0.5 * (1 + position->x) * area.width),
                float(area.y + 0.5 * (1 - position->y) * area.height)};
}

/// Writes on a shade that keeps text readable on light skin.
void write(ImDrawList& draw, ImVec2 at, const std::string& text) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const float pad = 0.25f * size.y;
  draw.AddRectFilled({at.x - pad, at.y - 0.5f * pad}, {at.x + size.x + pad, at.y + size.y + 0.5f * pad},
                     kShade, pad);
  draw.AddText(at, kInk, text.c_str());
}

void draw_line(ImDrawList& draw, const Viewer& viewer, const DrawnLine& line, ImU32 color) {
  const auto from = pixel_of(viewer, line.from), to = pixel_of(viewer, line.to);
  if (!from || !to) return;
  draw.AddLine(*from, *to, color, 3);
  draw.AddCircleFilled(*to, 5, color);
}

/// The line on the skin, and below it the edge of the blade.
void draw_cut(ImDrawList& draw, const Viewer& viewer, const DrawnLine& line) {
  const Vec3d below = line.on_skin.outward * -viewer.cut_depth;
  for (const SkinLine::Piece& piece : line.on_skin.pieces) {
    const auto from = pixel_of(viewer, piece.from), to = pixel_of(viewer, piece.to);
    const auto low_from = pixel_of(viewer, piece.from + below), low_to = pixel_of(viewer, piece.to + below);
    if (!from || !to || !low_from || !low_to) continue;
    const ImVec2 wall[] = {*from, *to, *low_to, *low_from};
    draw.AddConvexPolyFilled(wall, 4, kBlade);
    draw.AddLine(*low_from, *low_to, kBladeEdge, 1.5f);
    draw.AddLine(*from, *to, kLine, 3);
  }
  if (line.on_skin.pieces.empty()) draw_line(draw, viewer, line, kLine);
  const auto end = pixel_of(viewer, line.to);
  if (!end) return;
  draw.AddCircleFilled(*end, 5, kLine);
  write(draw, {end->x + 10, end->y - 8},
        fmt::format("{:.0f} mm, {:.0f} mm deep", 1e3 * line.on_skin.length, 1e3 * viewer.cut_depth));
}

/// The loop of a stitch that is being drawn.
void draw_stitch(ImDrawList& draw, const Viewer& viewer, const DrawnStitch& stitch) {
  const double depth = viewer.stitches.depth;
  const auto from = pixel_of(viewer, stitch.from.now);
  if (from) draw.AddCircleFilled(*from, 5, kThread);
  if (!stitch.to) return;
  const auto to = pixel_of(viewer, stitch.to->now),
             low_from = pixel_of(viewer, stitch.from.now - stitch.from.normal * depth),
             low_to = pixel_of(viewer, stitch.to->now - stitch.to->normal * depth);
  if (!from || !to || !low_from || !low_to) return;
  const ImVec2 loop[] = {*from, *low_from, *low_to, *to};
  draw.AddPolyline(loop, 4, kThread, 0, 1.5f);
  draw.AddLine(*from, *to, kThread, 3);
  draw.AddCircleFilled(*to, 5, kThread);
  write(draw, {to->x + 10, to->y - 8},
        fmt::format("{:.0f} mm, {:.1f} mm deep", 1e3 * norm(stitch.to->now - stitch.from.now), 1e3 * depth));
}

/// Forces of the stitches by hand, beside their threads.
void draw_forces(ImDrawList& draw, const Viewer& viewer) {
  for (const HandStitch& stitch : viewer.now->stitches) {
    const std::vector<TriMesh>& threads = viewer.now->snapshot.threads;
    const auto n = std::size_t(stitch.suture);
    if (n >= threads.size() || threads[n].vertices.empty()) continue;
    Vec3d middle;
    for (const Vec3 x : threads[n].vertices) middle += Vec3d(x) / double(threads[n].vertices.size());
    if (const auto at = pixel_of(viewer, middle))
      write(draw, {at->x + 14, at->y - 8}, fmt::format("{:.2f} N", stitch.tension));
  }
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

void draw_legend(ImDrawList& draw, const Area& area, const ColorScale& scale) {
  constexpr int kSteps = 32;
  constexpr float kWidth = 16, kHeight = 180;
  const ImVec2 end{float(area.x + area.width), float(area.y + area.height)};
  const ImVec2 corner{end.x - 100, end.y - kHeight - 30};
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
  write(draw, {end.x - width - 12, corner.y - 30}, scale.label);
}

/// Names of bodies and inclusions beside their colors, at the upper left.
void draw_names(ImDrawList& draw, const Area& area, const std::vector<NameRow>& rows) {
  const float size = ImGui::GetFontSize(), pad = 0.5f * size, line = ImGui::GetTextLineHeightWithSpacing();
  float width = 0;
  for (const NameRow& row : rows) width = std::max(width, ImGui::CalcTextSize(row.names.c_str()).x);
  const ImVec2 corner{float(area.x) + pad, float(area.y) + pad};
  draw.AddRectFilled(corner, {corner.x + width + size + 3 * pad, corner.y + float(rows.size()) * line + pad},
                     kShade, 0.25f * size);
  for (std::size_t n = 0; n < rows.size(); n++) {
    const Rgb c = rows[n].color;
    const ImVec2 at{corner.x + pad, corner.y + 0.75f * pad + float(n) * line};
    draw.AddRectFilled({at.x, at.y + 0.1f * size}, {at.x + 0.8f * size, at.y + 0.9f * size},
                       IM_COL32(c.r, c.g, c.b, 255));
    draw.AddText({at.x + size + pad, at.y}, kInk, rows[n].names.c_str());
  }
}

}  // namespace

void show_marks(const Viewer& viewer, const WorldPicture& picture) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const Area& area = viewer.area;
  draw.PushClipRect({float(area.x), float(area.y)},
                    {float(area.x + area.width), float(area.y + area.height)});
  for (const PictureLabel& label : picture.labels)
    if (const auto at = pixel_of(viewer, label.position)) write(draw, *at, label.text);
  if (viewer.display.patch)
    for (const BodySnapshot& body : viewer.now->snapshot.bodies) draw_patch(draw, viewer, body.patch);
  if (viewer.cut) draw_cut(draw, viewer, *viewer.cut);
  if (viewer.stitch) draw_stitch(draw, viewer, *viewer.stitch);
  if (viewer.mode == MouseMode::kSuture) draw_forces(draw, viewer);
  if (viewer.wind) draw_line(draw, viewer, *viewer.wind, kWindLine);
  if (picture.has_scale) draw_legend(draw, area, picture.scale);
  const bool is_drawn = viewer.now->phase == SessionStatus::Phase::kReady && !viewer.display.volume;
  if (is_drawn && !picture.names.empty()) draw_names(draw, area, picture.names);
  draw.PopClipRect();
}

}  // namespace turgor
