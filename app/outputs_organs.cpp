// Pictures, meshes and tables of organs that tools touch.
#include <algorithm>

#include <fmt/format.h>

#include "app/outputs.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/forces_csv.hpp"

namespace turgor {

namespace {

std::vector<const TriMesh*> tool_meshes(const World& world, const Organ& organ) {
  std::vector<const TriMesh*> meshes;
  for (const int t : organ.tool_indices) meshes.push_back(&world.tools[std::size_t(t)].shown);
  return meshes;
}

/// What presses a centimetre of the organ by a centimetre.
double usual_force(const SfemScene& scene) { return scene.material.young * 1e-4; }

double extent(const OrganSurface& surface) {
  TriMesh mesh;
  mesh.vertices = surface.rest;
  const Box box = bounding_box(mesh);
  return norm(box.high - box.low);
}

/// An organ as it lies at rest, untouched.
OrganSurface undeformed(const OrganSurface& surface) {
  OrganSurface rest = surface;
  std::fill(rest.displacement.begin(), rest.displacement.end(), Vec3{});
  std::fill(rest.pressure.begin(), rest.pressure.end(), 0.0f);
  rest.tools.clear();
  return rest;
}

/// The tool with the largest force.
std::size_t pressing_tool(const OrganSurface& surface) {
  std::size_t most = 0;
  for (std::size_t t = 1; t < surface.tools.size(); t++)
    if (norm(surface.tools[t].force) > norm(surface.tools[most].force)) most = t;
  return most;
}

/// From aside, so that both the dent and the tool are seen.
Camera camera_at_tool(const OrganSurface& surface, const TriMesh& mesh, double aspect) {
  const ShownTool& tool = surface.tools[pressing_tool(surface)];
  const Box size = bounding_box(mesh);
  const double reach = norm(size.high - size.low);
  const Vec3d half{reach, reach, reach}, out = normalized(tool.force);
  const Vec3d head = std::abs(out.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
  const Vec3d side = normalized(cross(out, head));
  return frame_box({tool.pose.position - half, tool.pose.position + half}, out + side * 0.9 + head * 0.55,
                   out, aspect);
}

/// One picture of one organ's surface.
std::optional<Image> draw_organ(const World& world, std::size_t index, const OrganSurface& surface,
                                const Camera& camera, double arrow, SkinColor color, Outputs& outputs) {
  const ColorScale scale = color_scale(*outputs.scene, color);
  PictureParts parts;
  add_organ(surface, tool_meshes(world, world.organs[index]),
            {usual_force(outputs.scene->organs[index]), arrow}, color,
            color == SkinColor::kNone ? nullptr : &scale, parts);
  return draw_parts(parts, camera, outputs);
}

/// How the organ lay when it was pressed most: the whole and from near, before and then, and in colours.
Status add_pressed_pictures(const World& world, std::size_t index, Outputs& outputs) {
  const Organ& organ = world.organs[index];
  if (!(organ.largest_force > 0)) return Done{};
  const OrganSurface& pressed = organ.deepest;
  const OrganSurface rest = undeformed(pressed);
  const std::size_t tool = pressing_tool(pressed);
  const double aspect = double(outputs.scene->output.width) / outputs.scene->output.height;
  const Camera whole = outputs.views.front().camera,
               near = camera_at_tool(pressed, *tool_meshes(world, organ)[tool], aspect);
  const std::string force =
      fmt::format("{:.2f} N at {:.2f} s", norm(pressed.tools[tool].force), pressed.time);
  struct View {
    const char* name;
    const char* caption;
    Camera camera;
    double arrow;  // length of a usual force's [m]
  };
  const Box tool_box = bounding_box(*tool_meshes(world, organ)[tool]);
  const double near_arrow = 0.5 * norm(tool_box.high - tool_box.low);
  for (const View& view : {View{"near", "from near", near, near_arrow},
                           View{"whole", "as a whole", whole, 0.2 * extent(rest)}}) {
    const auto before = draw_organ(world, index, rest, view.camera, view.arrow, SkinColor::kNone, outputs),
               then = draw_organ(world, index, pressed, view.camera, view.arrow, SkinColor::kNone, outputs);
    if (!before || !then) return Done{};
    const Status status =
        add_picture(outputs, fmt::format("{}-{}.png", organ.name, view.name),
                    fmt::format("{} {}, before and under the largest force", organ.name, view.caption),
                    side_by_side({*before, *then}, {"before", force}), true);
    if (!status) return status;
  }
  const auto moved = draw_organ(world, index, pressed, near, near_arrow, SkinColor::kDisplacement, outputs),
             pressure = draw_organ(world, index, pressed, near, near_arrow, SkinColor::kPressure, outputs);
  if (!moved || !pressure) return Done{};
  if (const Status s = add_picture(outputs, organ.name + "-displacement.png",
                                   organ.name + " from near: displacement", *moved, false);
      !s)
    return s;
  return add_picture(outputs, organ.name + "-pressure.png", organ.name + " from near: contact pressure",
                     *pressure, false);
}

}  // namespace

void show_organs(const Exec& exec, World& world) {
  for (Organ& organ : world.organs) {
    const Timer timer;
    organ.shown = shown_surface(exec, organ, time_of(world));
    organ.surface_seconds.push_back(timer.seconds());
  }
}

void add_organs(const World& world, const Scene& scene, SkinColor color, const ColorScale* scale,
                PictureParts& parts) {
  const bool known = color == SkinColor::kDisplacement || color == SkinColor::kPressure;
  for (std::size_t o = 0; o < world.organs.size(); o++)
    add_organ(world.organs[o].shown, tool_meshes(world, world.organs[o]),
              {usual_force(scene.organs[o]), 0.2 * extent(world.organs[o].shown)},
              known ? color : SkinColor::kNone, known ? scale : nullptr, parts);
}

Status write_organ_meshes(const World& world, Outputs& outputs) {
  for (const Organ& organ : world.organs) {
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", organ.name, world.frame);
    const Status status = write_vtu(outputs.folder / file, deformed_mesh(organ.shown, SkinColor::kNone),
                                    {vertex_field("displacement [m]", organ.shown.displacement),
                                     vertex_field("pressure [Pa]", organ.shown.pressure)});
    if (!status) return status;
    outputs.series.push_back({time_of(world), file, organ.name});
  }
  return Done{};
}

Status finish_organ_outputs(const World& world, Outputs& outputs) {
  for (std::size_t o = 0; o < world.organs.size(); o++) {
    if (const Status status = add_pressed_pictures(world, o, outputs); !status) return status;
    const Organ& organ = world.organs[o];
    if (!outputs.scene->output.obj || !(organ.largest_force > 0)) continue;
    const std::string file = organ.name + ".obj";
    if (const Status s = write_obj(outputs.folder / file, deformed_mesh(organ.deepest, SkinColor::kNone)); !s)
      return s;
    outputs.facts.files.push_back(file);
  }
  if (world.tools.empty()) return Done{};
  if (const Status status = write_forces(outputs.folder / "forces.csv", world.tools); !status) return status;
  outputs.facts.files.push_back("forces.csv");
  return Done{};
}

}  // namespace turgor
