#include "turgor/pictures/picture_parts.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/tools/tool_mesh.hpp"

namespace turgor {

namespace {

constexpr Rgb kFlesh{158, 68, 56}, kSkin{224, 172, 145}, kWall{166, 58, 50}, kCloth{92, 134, 176},
    kObstacle{188, 180, 168}, kTool{176, 190, 204}, kArrow{250, 204, 70}, kInside{236, 214, 150};

std::string newtons(double force) {
  return force < 0.1 ? fmt::format("{:.0f} mN", force * 1e3) : fmt::format("{:.2f} N", force);
}

/// From where the tool ends, in the direction of the force on it.
void add_arrow(const ToolSnapshot& tool, const TriMesh& mesh, ArrowScale arrows, Vec3d eye,
               PictureParts& parts) {
  const double force = norm(tool.force);
  if (!(force > 1e-3 * arrows.force)) return;
  const Vec3d direction = tool.force / force;
  double beyond = 0;
  for (const Vec3 x : mesh.vertices) beyond = std::max(beyond, dot(Vec3d(x) - tool.pose.position, direction));
  const double length = arrows.length * std::clamp(force / arrows.force, 0.25, kLongestArrow);
  const double thickness = 0.06 * arrows.length;
  Vec3d tail = tool.pose.position + direction * beyond;
  const bool pulls = dot(direction, tool.pose.axes.column[2]) < -0.5;
  if (pulls) {  // beside the tool as it is seen: it and the body would hide it
    const Vec3d beside = normalized(cross(direction, eye - tool.pose.position));
    tail = tool.pose.position - direction * length - beside * (0.4 * arrows.length);
  }
  parts.add(arrow_mesh(tail, tail + direction * length, thickness), kArrow);
  const Vec3d end = pulls ? tail - direction * (2 * thickness) : tail + direction * (length + 2 * thickness);
  parts.labels.push_back({end, newtons(force)});
}

/// Both sides, for light that only knows one.
TriMesh two_sided(TriMesh mesh) {
  const int count = int(mesh.vertices.size());
  const std::size_t triangles = mesh.triangles.size();
  mesh.vertices.insert(mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.begin() + count);
  mesh.scalars.insert(mesh.scalars.end(), mesh.scalars.begin(), mesh.scalars.end());
  for (int v = 0; v < count; v++) mesh.normals.push_back(-mesh.normals[std::size_t(v)]);
  for (std::size_t t = 0; t < triangles; t++) {
    const auto [a, b, c] = mesh.triangles[t];
    mesh.triangles.push_back({a + count, c + count, b + count});
  }
  return mesh;
}

Rgb color_of(Look look) { return look == Look::kSkin ? kSkin : look == Look::kCloth ? kCloth : kFlesh; }

/// Beside tissue, which moves by millimetres, cloth is drawn as cloth.
bool is_beside_tissue(const BodySnapshot& body, const WorldSnapshot& snapshot) {
  return body.look == Look::kCloth &&
         std::any_of(snapshot.bodies.begin(), snapshot.bodies.end(),
                     [](const BodySnapshot& other) { return other.look != Look::kCloth; });
}

}  // namespace

std::vector<float> shown_values(const BodySnapshot& body, SkinColor color) {
  if (color == SkinColor::kStretch) return body.stretch;
  if (color == SkinColor::kPressure) return body.pressure;
  std::vector<float> lengths;
  if (color == SkinColor::kDisplacement)
    for (const Vec3 u : body.displacement) lengths.push_back(norm(u));
  return lengths;
}

TriMesh shown_mesh(const BodySnapshot& body) {
  return {.vertices = body.x, .triangles = body.triangles, .normals = body.normals, .scalars = {}};
}

void add_body(const BodySnapshot& body, SkinColor color, const ColorScale* scale, PictureParts& parts) {
  if (body.triangles.empty()) return;
  TriMesh surface = shown_mesh(body);
  surface.scalars = shown_values(body, color);
  if (surface.scalars.empty()) scale = nullptr;
  if (body.wall_begin < body.triangles.size()) {
    const auto split = std::ptrdiff_t(body.wall_begin);
    TriMesh walls = surface;
    walls.triangles.erase(walls.triangles.begin(), walls.triangles.begin() + split);
    surface.triangles.resize(body.wall_begin);
    parts.add(std::move(walls), kWall);
    parts.parts.back().closed = true;
  }
  if (body.look == Look::kCloth) surface = two_sided(std::move(surface));
  parts.add(std::move(surface), color_of(body.look), scale);
  parts.parts.back().closed = true;
  if (scale || body.inside.triangles.empty()) return;  // it would hide the colours above it
  parts.add(body.inside, kInside);
  parts.parts.back().through = parts.parts.back().closed = true;
}

TriMesh placed_mesh(const ToolSnapshot& tool) {
  TriMesh mesh = tool.mesh;
  for (Vec3& x : mesh.vertices) x = Vec3(contact::to_world(tool.pose, Vec3d(x)));
  for (Vec3& n : mesh.normals) n = Vec3(tool.pose.axes * Vec3d(n));
  return mesh;
}

void add_tool(const ToolSnapshot& tool, ArrowScale arrows, Vec3d eye, PictureParts& parts) {
  add_arrow(tool, parts.add(placed_mesh(tool), kTool), arrows, eye, parts);
}

void add_world(const WorldSnapshot& snapshot, SkinColor color, const ColorScale* scale, Vec3d eye,
               PictureParts& parts) {
  for (const BodySnapshot& body : snapshot.bodies)
    is_beside_tissue(body, snapshot) ? add_body(body, SkinColor::kNone, nullptr, parts)
                                     : add_body(body, color, scale, parts);
  for (const ToolSnapshot& tool : snapshot.tools) {
    const BodySnapshot& body = body_snapshot(snapshot, tool.body);
    add_tool(tool, {body.usual_force, 0.2 * norm(body.box.high - body.box.low)}, eye, parts);
  }
  for (const TriMesh& obstacle : snapshot.obstacles) parts.add(obstacle, kObstacle);
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
