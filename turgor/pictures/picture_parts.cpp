#include "turgor/pictures/picture_parts.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/tools/tool_mesh.hpp"

namespace turgor {

namespace {

constexpr Rgb kFlesh{158, 68, 56}, kTool{176, 190, 204}, kArrow{250, 204, 70};

TriMesh placed(const TriMesh& tool, const contact::Pose& pose) {
  TriMesh mesh = tool;
  for (Vec3& x : mesh.vertices) x = Vec3(contact::to_world(pose, Vec3d(x)));
  for (Vec3& n : mesh.normals) n = Vec3(pose.axes * Vec3d(n));
  return mesh;
}

std::string newtons(double force) {
  return force < 0.1 ? fmt::format("{:.0f} mN", force * 1e3) : fmt::format("{:.2f} N", force);
}

/// From where the tool ends, in the direction of the force on it.
void add_arrow(const ShownTool& tool, const TriMesh& mesh, ArrowScale arrows, PictureParts& parts) {
  const double force = norm(tool.force);
  if (!(force > 1e-3 * arrows.force)) return;
  const Vec3d direction = tool.force / force;
  double beyond = 0;
  for (const Vec3 x : mesh.vertices) beyond = std::max(beyond, dot(Vec3d(x) - tool.pose.position, direction));
  const double length = arrows.length * std::clamp(force / arrows.force, 0.25, 3.0);
  const double thickness = 0.06 * arrows.length;
  Vec3d tail = tool.pose.position + direction * beyond;
  const bool pulls = dot(direction, tool.pose.axes.column[2]) < -0.5;
  if (pulls)  // beside the tool: the body would hide it
    tail = tool.pose.position - direction * length - tool.pose.axes.column[0] * (0.5 * arrows.length);
  parts.add(arrow_mesh(tail, tail + direction * length, thickness), kArrow);
  const Vec3d end = pulls ? tail - direction * (2 * thickness) : tail + direction * (length + 2 * thickness);
  parts.labels.push_back({end, newtons(force)});
}

}  // namespace

TriMesh deformed_mesh(const ShownSurface& surface, SkinColor color) {
  TriMesh mesh;
  mesh.triangles = surface.triangles;
  for (std::size_t v = 0; v < surface.rest.size(); v++)
    mesh.vertices.push_back(surface.rest[v] + surface.displacement[v]);
  if (color == SkinColor::kPressure) mesh.scalars = surface.pressure;
  if (color == SkinColor::kDisplacement)
    for (const Vec3 u : surface.displacement) mesh.scalars.push_back(norm(u));
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

void add_body(const ShownSurface& surface, const std::vector<TriMesh>& tools, ArrowScale arrows,
              SkinColor color, const ColorScale* scale, PictureParts& parts) {
  if (!surface.triangles.empty()) parts.add(deformed_mesh(surface, color), kFlesh, scale);
  for (std::size_t t = 0; t < std::min(tools.size(), surface.tools.size()); t++) {
    const TriMesh& mesh = parts.add(placed(tools[t], surface.tools[t].pose), kTool);
    add_arrow(surface.tools[t], mesh, arrows, parts);
  }
}

void draw_labels(const std::vector<PictureLabel>& labels, const Camera& camera, Image& image) {
  const CameraFrame frame = camera_frame(camera);
  for (const PictureLabel& label : labels) {
    const Vec3d seen = label.place - camera.eye;
    const double depth = -dot(seen, frame.back), half = depth * frame.tan_half;
    if (!(depth > 0)) continue;
    const double x = dot(seen, frame.right) / half, y = dot(seen, frame.up) / half;
    draw_text(image, label.text, int(0.5 * (image.width + x * image.height)),
              int(0.5 * image.height * (1 - y)),
              {.size = std::max(15, image.height / 30), .align = Align::kCenter, .halo = true});
  }
}

}  // namespace turgor
