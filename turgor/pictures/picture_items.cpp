#include "turgor/pictures/picture_items.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "turgor/sim/report/report_skin.hpp"
#include "turgor/sim/tools/tool_mesh.hpp"

namespace turgor {

namespace {

constexpr Rgb kSkin{224, 172, 145}, kCloth{92, 134, 176}, kArrow{250, 204, 70};

std::string newtons(double force) {
  return force < 0.1 ? fmt::format("{:.0f} mN", force * 1e3) : fmt::format("{:.2f} N", force);
}

/// Arrow from the end of the tool in the direction of the force on it.
void add_arrow(const ToolSnapshot& tool, const TriMesh& mesh, ArrowScale arrows, Vec3d eye,
               PictureItems& items) {
  const double force = norm(tool.force);
  if (!(force > 1e-3 * arrows.force)) return;
  const Vec3d direction = tool.force / force;
  double beyond = 0;
  for (const Vec3 x : mesh.vertices) beyond = std::max(beyond, dot(Vec3d(x) - tool.pose.position, direction));
  const double length = arrows.length * std::clamp(force / arrows.force, 0.25, kLongestArrow);
  const double thickness = 0.06 * arrows.length;
  Vec3d tail = tool.pose.position + direction * beyond;
  const bool pulls = dot(direction, tool.pose.axes.column[2]) < -0.5;
  if (pulls) {  // drawn beside the tool as seen by the camera, because tool and body would hide it
    const Vec3d beside = normalized(cross(direction, eye - tool.pose.position));
    tail = tool.pose.position - direction * length - beside * (0.4 * arrows.length);
  }
  items.add(arrow_mesh(tail, tail + direction * length, thickness), kArrow);
  const Vec3d end = pulls ? tail - direction * (2 * thickness) : tail + direction * (length + 2 * thickness);
  items.labels.push_back({end, newtons(force)});
}

/// Duplicates triangles for both sides, for renderers with one-sided lighting.
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

/// Takes the triangles from number `begin` on out of a mesh, with the range of vertices that they use.
TriMesh take_triangles(std::size_t begin, TriMesh& whole) {
  TriMesh found;
  found.triangles.assign(whole.triangles.begin() + std::ptrdiff_t(begin), whole.triangles.end());
  whole.triangles.resize(begin);
  int low = int(whole.vertices.size()), high = -1;
  for (const Int3 t : found.triangles)
    low = std::min({low, t.x, t.y, t.z}), high = std::max({high, t.x, t.y, t.z});
  for (Int3& t : found.triangles) t = t - Int3{low, low, low};
  const auto copy = [&](const auto& from, auto& to) {
    if (from.size() == whole.vertices.size()) to.assign(from.begin() + low, from.begin() + high + 1);
  };
  copy(whole.vertices, found.vertices), copy(whole.normals, found.normals),
      copy(whole.scalars, found.scalars);
  return found;
}

/// Usual color of an organ whose name contains a word.
struct OrganColor {
  std::string_view word;
  Rgb color;
};
constexpr OrganColor kOrgans[] = {
    {"liver", {158, 68, 56}},       {"gall", {112, 124, 62}},     {"stomach", {204, 128, 114}},
    {"spleen", {120, 62, 92}},      {"kidney", {138, 56, 48}},    {"pancreas", {206, 160, 104}},
    {"lung", {214, 150, 146}},      {"heart", {176, 52, 52}},     {"colon", {196, 142, 118}},
    {"intestine", {200, 136, 122}}, {"bladder", {190, 150, 110}}, {"uterus", {190, 104, 104}},
};
/// Other bodies, in their order within a model.
constexpr Rgb kBodies[] = {{158, 68, 56}, {204, 128, 114}, {128, 74, 108}, {190, 142, 88}, {112, 124, 62}};

/// Cloth is drawn in its own color if the world has tissue, whose displacements are millimeters.
bool is_beside_tissue(const BodySnapshot& body, const WorldSnapshot& snapshot) {
  return body.look == Look::kCloth &&
         std::any_of(snapshot.bodies.begin(), snapshot.bodies.end(),
                     [](const BodySnapshot& other) { return other.look != Look::kCloth; });
}

}  // namespace

Rgb natural_color(const BodySnapshot& body) {
  if (body.look == Look::kSkin) return kSkin;
  if (body.look == Look::kCloth) return kCloth;
  for (const OrganColor& organ : kOrgans)
    if (body.name.find(organ.word) != std::string::npos) return organ.color;
  return kBodies[std::size_t(std::max(0, body.id.index)) % std::size(kBodies)];
}

std::vector<float> shown_values(const BodySnapshot& body, SkinColor color) {
  const bool is_smooth = !body.smooth.triangles.empty();
  if (color == SkinColor::kStretch) return is_smooth ? std::vector<float>() : body.stretch;
  if (color == SkinColor::kPrincipalStretch) return is_smooth ? std::vector<float>() : skin_stretches(body);
  if (color == SkinColor::kPressure) return is_smooth ? body.smooth.pressure : body.pressure;
  std::vector<float> lengths;
  if (color == SkinColor::kDisplacement)
    for (const Vec3 u : is_smooth ? body.smooth.displacement : body.displacement) lengths.push_back(norm(u));
  return lengths;
}

TriMesh surface_mesh(const BodySnapshot& body) {
  return {.vertices = body.x, .triangles = body.triangles, .normals = body.normals, .scalars = {}};
}

TriMesh shown_mesh(const BodySnapshot& body) {
  if (const SmoothSnapshot& smooth = body.smooth; !smooth.triangles.empty())
    return {.vertices = smooth.x, .triangles = smooth.triangles, .normals = smooth.normals, .scalars = {}};
  return surface_mesh(body);
}

ColoredWalls colored_walls(const BodySnapshot& body) {
  const WallLayers& walls = body.wall_layers;
  ColoredWalls result;
  result.mesh.triangles = walls.triangles;
  for (std::size_t v = 0; v < walls.corner.size(); v++) {
    Vec3 x, normal;
    for (int corner = 0; corner < 3; corner++) {
      const auto at = std::size_t(walls.corner[v][corner]);
      x += body.x[at] * walls.weight[v][corner], normal += body.normals[at] * walls.weight[v][corner];
    }
    result.mesh.vertices.push_back(x), result.mesh.normals.push_back(normalized(normal));
    const bool has_look = walls.layer[v] < walls.looks.size();
    result.colors.push_back(has_look ? walls.looks[walls.layer[v]].color.value_or(kWallColor) : kWallColor);
  }
  return result;
}

Rgb section_color(const BodySnapshot& body) {
  return body.look == Look::kSkin ? Rgb{196, 112, 92} : mix(natural_color(body), {255, 226, 208}, 0.3f);
}

bool is_wet(const BodySnapshot& body, const LookScene& look) {
  const auto set = look.wet.find(body.name);
  if (set != look.wet.end()) return set->second;
  return body.look == Look::kFlesh && body.id.kind != BodyKind::kLattice;
}

Cutaway cutaway_of(const BodySnapshot& body, const LookScene& look) {
  if (!look.cutaway || look.cutaway->body != body.id) return {};
  const CutawayPlanes planes = cutaway_planes(*look.cutaway, body.box);
  Cutaway cutaway;
  for (const Vec3d normal : planes.normals) cutaway.plane[cutaway.planes++] = {planes.at, normal};
  return cutaway;
}

namespace {

/// Section of a closed surface.
void add_section(TriMesh closed, Rgb color, const Cutaway& cutaway, bool wet, PictureItems& items) {
  items.add(std::move(closed), color);
  RenderItem& item = items.items.back();
  item.cutaway = cutaway, item.is_cut_face = true, item.wet = wet;
}

/// Gray values of a section of a CT, seen from the removed side.
FacePicture face_picture(const CtVolume& section, Window window) {
  const Grid& grid = section.grid;
  FacePicture picture{.corner = grid.origin,
                      .right = grid.axes.column[0] * grid.spacing.x,
                      .up = grid.axes.column[1] * grid.spacing.y,
                      .image = make_image(grid.size.x, grid.size.y)};
  std::transform(section.samples.begin(), section.samples.end(), picture.image.pixels.begin(),
                 [window](std::int16_t hu) {
                   const std::uint8_t gray = gray_value(hu, window);
                   return Rgb{gray, gray, gray};
                 });
  return picture;
}

/// Gray values of the section that was added last, if the body has them.
bool add_gray_values(const BodySnapshot& body, const LookScene& look, PictureItems& items) {
  RenderItem& item = items.items.back();
  const Result<Window> window = window_preset(look.window);
  if (body.sections.size() != std::size_t(item.cutaway.planes) || !window) return false;
  for (const CtVolume& section : body.sections) item.face_pictures.push_back(face_picture(section, *window));
  item.wet = false;  // its highlights would read as bone
  return true;
}

/// Inclusions, which are seen through the body, stand out of its section or are cut with it.
void add_inclusions(const BodySnapshot& body, const ColorScale* scale, const Cutaway& cutaway, bool are_cut,
                    PictureItems& items) {
  if (scale && cutaway.planes == 0) return;  // they would hide the colors above them
  items.add(body.inside, kInsideColor);
  items.items.back().closed = true;
  items.items.back().see_through = !scale;
  if (are_cut) {
    items.items.back().cutaway = cutaway;
    add_section(body.inside, kInsideColor, cutaway, false, items);
  }
  for (const std::string& name : body.inside_names) add_name(kInsideColor, name, items.names);
}

/// Walls of wounds, in the colors of their layers if these have colors.
void add_walls(const BodySnapshot& body, TriMesh walls, PictureItems& items) {
  ColoredWalls colored = colored_walls(body);
  if (colored.mesh.triangles.empty()) {
    items.add(std::move(walls), kWallColor);
    return;
  }
  items.add(std::move(colored.mesh), kWallColor);
  items.colors.push_back(std::move(colored.colors));
  items.items.back().colors = &items.colors.back();
  for (const LayerLook& look : body.wall_layers.looks)
    if (look.color) add_name(*look.color, look.name, items.names);
}

}  // namespace

void add_body(const BodySnapshot& body, SkinColor color, const ColorScale* scale, PictureItems& items,
              const LookScene& look) {
  if (body.triangles.empty()) return;
  const Cutaway cutaway = cutaway_of(body, look);
  TriMesh surface = shown_mesh(body);
  TriMesh closed = cutaway.planes > 0 ? surface : TriMesh();
  surface.scalars = shown_values(body, color);
  if (surface.scalars.empty()) scale = nullptr;

  // walls of wounds, and caps where the CT ends
  const auto finish = [&] {
    RenderItem& item = items.items.back();
    item.closed = true, item.cutaway = cutaway;
    item.wet = look.wet.contains(body.name) && look.wet.at(body.name);
  };
  if (body.smooth.triangles.empty()) {
    const std::size_t outer = outer_triangles(body).size();
    if (body.wall_begin < surface.triangles.size())
      add_walls(body, take_triangles(body.wall_begin, surface), items), finish();
    if (outer < surface.triangles.size())
      items.add(take_triangles(outer, surface), section_color(body)), finish();
  }

  // surface and section
  if (body.look == Look::kCloth) surface = two_sided(std::move(surface));
  const Rgb own = natural_color(body);
  items.add(std::move(surface), own, scale);
  RenderItem& item = items.items.back();
  item.closed = true, item.cutaway = cutaway, item.wet = is_wet(body, look);
  item.in_fours = !body.smooth.triangles.empty();
  item.opaque = body.look == Look::kCloth;  // cloth and rigid bodies
  if (!scale) add_name(own, body.name, items.names);
  if (cutaway.planes > 0) {
    add_section(std::move(closed), section_color(body), cutaway, body.look != Look::kCloth, items);
    if (!add_gray_values(body, look, items)) add_name(section_color(body), body.name + ", cut", items.names);
  }
  if (!body.inside.triangles.empty())
    add_inclusions(body, scale, cutaway, look.cutaway && look.cutaway->cuts_inclusions && cutaway.planes > 0,
                   items);
}

TriMesh posed_mesh(const ToolSnapshot& tool) {
  TriMesh mesh = tool.mesh;
  for (Vec3& x : mesh.vertices) x = Vec3(contact::to_world(tool.pose, Vec3d(x)));
  for (Vec3& n : mesh.normals) n = Vec3(tool.pose.axes * Vec3d(n));
  return mesh;
}

void add_tool(const ToolSnapshot& tool, ArrowScale arrows, Vec3d eye, PictureItems& items) {
  const TriMesh& mesh = items.add(posed_mesh(tool), kToolColor);
  items.items.back().opaque = true;
  add_arrow(tool, mesh, arrows, eye, items);
}

void add_organ_forces(const WorldSnapshot& snapshot, PictureItems& items) {
  for (const OrganForce& one : snapshot.organ_forces) {
    const BodySnapshot& body = body_snapshot(snapshot, one.body);
    const double force = norm(one.force), unit = 0.2 * norm(body.box.high - body.box.low);
    if (!(force > 1e-3 * body.typical_force)) continue;
    const double length = unit * std::clamp(force / body.typical_force, 0.25, kLongestArrow);
    const Vec3d end = one.at + one.force * (length / force);
    items.add(arrow_mesh(one.at, end, 0.06 * unit), kArrow);
    RenderItem& arrow = items.items.back();
    arrow.see_through = arrow.is_mark = arrow.closed = true;
    items.labels.push_back({end, one.name + " " + newtons(force)});
  }
}

void add_world(const WorldSnapshot& snapshot, SkinColor color, const ColorScale* scale, Vec3d eye,
               PictureItems& items, const LookScene& look, std::size_t tools) {
  for (const BodySnapshot& body : snapshot.bodies)
    is_beside_tissue(body, snapshot) ? add_body(body, SkinColor::kNone, nullptr, items, look)
                                     : add_body(body, color, scale, items, look);
  for (std::size_t t = 0; t < std::min(tools, snapshot.tools.size()); t++) {
    const ToolSnapshot& tool = snapshot.tools[t];
    const BodySnapshot& body = body_snapshot(snapshot, tool.body);
    add_tool(tool, {body.typical_force, 0.2 * norm(body.box.high - body.box.low)}, eye, items);
  }
  for (const TriMesh& obstacle : snapshot.obstacles)
    items.add(obstacle, kObstacleColor), items.items.back().opaque = true;
  for (const TriMesh& thread : snapshot.threads)
    if (!thread.triangles.empty()) items.add(thread, kThreadColor), items.items.back().opaque = true;
}

std::vector<NameRow> shown_names(const PictureItems& items) {
  return items.names.size() < 2 ? std::vector<NameRow>() : items.names;
}

void draw_labels(const std::vector<PictureLabel>& labels, const Camera& camera, Image& image) {
  const CameraFrame frame = camera_frame(camera);
  for (const PictureLabel& label : labels) {
    const Vec3d from_eye = label.position - camera.eye;
    const double depth = -dot(from_eye, frame.back), half = depth * frame.tan_half;
    if (!(depth > 0)) continue;
    const double x = dot(from_eye, frame.right) / half, y = dot(from_eye, frame.up) / half;
    draw_text(image, label.text, int(0.5 * (image.width + x * image.height)),
              int(0.5 * image.height * (1 - y)),
              {.size = std::max(15, image.height / 30), .align = Align::kCenter, .halo = true});
  }
}

}  // namespace turgor
