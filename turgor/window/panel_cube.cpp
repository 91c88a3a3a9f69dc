#include <array>
#include <cmath>

#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

/// Face of the cube: outward axis in LPS, its letter, and the key of its view.
struct Face {
  Vec3d out;
  const char *letter, *name, *key;
};
constexpr Face kFaces[] = {{{0, -1, 0}, "A", "anterior: from the front", "1"},
                           {{0, 1, 0}, "P", "posterior: from the back", "2"},
                           {{-1, 0, 0}, "R", "from the patient's right", "3"},
                           {{1, 0, 0}, "L", "from the patient's left", "4"},
                           {{0, 0, 1}, "H", "from the head", "5"},
                           {{0, 0, -1}, "F", "from the feet", "6"}};

/// Corners of a face in the window, counter-clockwise seen from outside, without perspective.
std::array<ImVec2, 4> corners_of(const Face& face, const CameraFrame& frame, ImVec2 center, float half) {
  const Vec3d side = std::abs(face.out.z) > 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 0, 1};
  const Vec3d other = cross(face.out, side);
  std::array<ImVec2, 4> corners;
  constexpr int kSigns[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (std::size_t c = 0; c < 4; c++) {
    const Vec3d p = face.out + side * kSigns[c][0] + other * kSigns[c][1];
    corners[c] = {center.x + half * float(dot(p, frame.right)), center.y - half * float(dot(p, frame.up))};
  }
  return corners;
}

bool is_inside(const std::array<ImVec2, 4>& corners, ImVec2 point) {
  int left = 0;
  for (std::size_t c = 0; c < 4; c++) {
    const ImVec2 a = corners[c], b = corners[(c + 1) % 4];
    left += (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x) > 0;
  }
  return left == 0 || left == 4;
}

/// Draws a visible face. True: the cursor is over it.
bool draw_face(ImDrawList& draw, const Face& face, const CameraFrame& frame, ImVec2 center, float half) {
  const std::array<ImVec2, 4> corners = corners_of(face, frame, center, half);
  const bool is_hovered = ImGui::IsItemHovered() && is_inside(corners, ImGui::GetIO().MousePos);
  const int bright = int(110 + 90 * dot(face.out, frame.back));
  const ImU32 fill =
      is_hovered ? ImGui::GetColorU32(ImGuiCol_ButtonHovered) : IM_COL32(bright, bright, bright, 235);
  draw.AddConvexPolyFilled(corners.data(), 4, fill);
  draw.AddPolyline(corners.data(), 4, IM_COL32(40, 44, 50, 255), ImDrawFlags_Closed, 1);
  const ImVec2 size = ImGui::CalcTextSize(face.letter);
  const ImVec2 middle{0.5f * (corners[0].x + corners[2].x), 0.5f * (corners[0].y + corners[2].y)};
  if (dot(face.out, frame.back) > 0.35)
    draw.AddText({middle.x - 0.5f * size.x, middle.y - 0.5f * size.y}, IM_COL32(20, 22, 26, 255),
                 face.letter);
  return is_hovered;
}

}  // namespace

void show_cube(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  if (now.phase != SessionStatus::Phase::kReady || viewer.shows_gallery) return;
  const float size = 5 * ImGui::GetFontSize();
  const Area& area = viewer.area;
  ImGui::SetNextWindowPos({float(area.x + area.width) - size - 8, float(area.y) + 8});
  ImGui::SetNextWindowSize({size, size});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBackground;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2{0, 0});
  if (ImGui::Begin("cube", nullptr, kFlags)) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const bool is_clicked = ImGui::InvisibleButton("cube", {size, size});
    const bool is_dragged = ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left, 4);
    const CameraFrame frame = camera_frame(viewer.camera);
    const ImVec2 center{corner.x + 0.5f * size, corner.y + 0.5f * size};
    const Face* hovered = nullptr;
    for (const Face& face : kFaces)
      if (dot(face.out, frame.back) > 0 &&
          draw_face(*ImGui::GetWindowDrawList(), face, frame, center, 0.28f * size))
        hovered = &face;
    if (hovered && !ImGui::IsItemActive()) ImGui::SetTooltip("%s (%s)", hovered->name, hovered->key);
    const ImVec2 drag = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 4);
    if (is_dragged) {
      const ImVec2 move = ImGui::GetIO().MouseDelta;
      viewer.camera = orbited(viewer.camera, -double(move.x) / double(size), double(move.y) / double(size));
    } else if (is_clicked && hovered && drag.x == 0 && drag.y == 0) {
      act(viewer, hovered->key);
    }
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace turgor
