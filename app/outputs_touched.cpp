// Pictures, meshes and tables of bodies that tools touch.
#include <algorithm>

#include <fmt/format.h>

#include "app/outputs.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/forces_csv.hpp"

namespace turgor {

namespace {

/// The tools of a body, their jaws as in `surface`.
std::vector<TriMesh> tool_meshes(const World& world, const TouchedBody& body, const ShownSurface& surface) {
  std::vector<TriMesh> meshes;
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    const double opening = t < surface.tools.size() ? surface.tools[t].opening : 0;
    meshes.push_back(tool.forceps ? contact::forceps_mesh(*tool.forceps, opening) : tool.shown);
  }
  return meshes;
}

/// Of the part of a tool that touches [m].
double tool_size(const TouchingTool& tool) {
  if (tool.forceps) return 3 * tool.forceps->opening;
  const Box box = bounding_box(tool.shown);
  return norm(box.high - box.low);
}

/// What presses a centimetre of the body by a centimetre.
double usual_force(const Scene& scene, BodyId id) {
  const auto b = std::size_t(id.index);
  if (id.kind == BodyKind::kSfem) return scene.sfem_bodies[b].material.young * 1e-4;
  if (id.kind == BodyKind::kLattice) return scene.lattice_bodies[b].params.tissue.muscle * 1e-4;
  const auto chain = rhombus::build_chain(scene.rhombus_bodies[b].params.chain);
  return chain ? rhombus::force_of_depth(*chain, 0.01) : 1;
}

double extent(const ShownSurface& surface) {
  TriMesh mesh;
  mesh.vertices = surface.rest;
  const Box box = bounding_box(mesh);
  return norm(box.high - box.low);
}

double extent(const TouchedBody& body) { return extent(body.shown); }
/// Its surface is drawn as skin.
double extent(const LatticeBody& body) {
  const BodyBox box = body_box(body.model);
  return norm(box.high - box.low);
}

/// A body as it lies at rest, untouched.
ShownSurface undeformed(const ShownSurface& surface) {
  ShownSurface rest = surface;
  std::fill(rest.displacement.begin(), rest.displacement.end(), Vec3{});
  std::fill(rest.pressure.begin(), rest.pressure.end(), 0.0f);
  rest.tools.clear();
  return rest;
}

/// The tool with the largest force.
std::size_t pressing_tool(const ShownSurface& surface) {
  std::size_t most = 0;
  for (std::size_t t = 1; t < surface.tools.size(); t++)
    if (norm(surface.tools[t].force) > norm(surface.tools[most].force)) most = t;
  return most;
}

/// Out of the surface at rest around a place; zero when there is none within reach.
Vec3d outward_around(const ShownSurface& surface, Vec3d place, double reach) {
  Vec3d sum;
  for (const Int3 t : surface.triangles) {
    const Vec3d a(surface.rest[std::size_t(t.x)]), b(surface.rest[std::size_t(t.y)]),
        c(surface.rest[std::size_t(t.z)]);
    if (norm(a - place) < reach) sum += cross(b - a, c - a);
  }
  return sum;
}

/// At what the pressing tool touches. From aside one sees the dent with the tool in it, from above, where it
/// is left out, what lies below it.
Camera camera_at_tool(const ShownSurface& surface, const TouchingTool& which, bool from_above,
                      double aspect) {
  const ShownTool& tool = surface.tools[pressing_tool(surface)];
  const double reach = (from_above ? 0.7 : 0.8) * tool_size(which);
  const Vec3d half{reach, reach, reach},
      outward = outward_around(surface, tool.pose.position, 2 * tool_size(which));
  // Tools that pull are pulled in; forceps come from where their handles are.
  const bool pulls = dot(tool.force, outward) < 0;
  const Vec3d out = which.forceps ? tool.pose.axes.column[2] : normalized(pulls ? outward : tool.force);
  const Vec3d head = std::abs(out.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
  const Vec3d side = normalized(cross(out, head));
  const Vec3d direction = from_above ? out + side * 0.45 + head * 0.25
                                     : out * (which.forceps ? 0.25 : 0.7) + side * 0.9 + head * 0.55;
  return frame_box({tool.pose.position - half, tool.pose.position + half}, direction, out, aspect);
}

/// One picture of one body's surface, with tools and forces as they are.
std::optional<Image> draw_body(const World& world, BodyId id, const ShownSurface& surface,
                               const Camera& camera, double arrow, Outputs& outputs) {
  PictureParts parts;
  add_body(surface, tool_meshes(world, touched_body(world, id), surface),
           {usual_force(*outputs.scene, id), arrow}, SkinColor::kNone, nullptr, parts);
  return draw_parts(parts, camera, outputs);
}

/// In colours that reach to the largest value, unless the scene says otherwise; without the tools.
Status add_colored(const TouchedBody& body, SkinColor color, const char* name, const char* caption,
                   const Camera& camera, Outputs& outputs) {
  ShownSurface surface = body.deepest;
  surface.tools.clear();
  const OutputScene& output = outputs.scene->output;
  ColorScale scale = color_scale(*outputs.scene, color);
  const std::vector<float> values = deformed_mesh(surface, color).scalars;
  if (output.color != color || !output.color_range)
    scale.high = *std::max_element(values.begin(), values.end());
  PictureParts parts;
  add_body(surface, {}, {}, color, &scale, parts);
  const std::optional<Image> image = draw_parts(parts, camera, outputs);
  if (!image) return Done{};
  return add_picture(outputs, fmt::format("{}-{}.png", body.name, name),
                     fmt::format("{} under the largest force, the tool left out: {}", body.name, caption),
                     *image, false);
}

/// How the body lay when it was pressed most: the whole and from near, before and then, and in colours.
Status add_pressed_pictures(const World& world, BodyId id, const TouchedBody& body, Outputs& outputs) {
  if (!(body.largest_force > 0)) return Done{};
  const ShownSurface& pressed = body.deepest;
  const ShownSurface rest = undeformed(pressed);
  const std::size_t tool = pressing_tool(pressed);
  const TouchingTool& pressing = world.tools[std::size_t(body.tool_indices[tool])];
  const double aspect = double(outputs.scene->output.width) / outputs.scene->output.height;
  const Camera whole = outputs.views.front().camera, near = camera_at_tool(pressed, pressing, false, aspect);
  const std::string force =
      fmt::format("{:.3g} N at {:.2f} s", norm(pressed.tools[tool].force), pressed.time);
  struct View {
    const char* name;
    const char* caption;
    Camera camera;
    double arrow;  // length of a usual force's [m]
  };
  const double near_arrow = 0.5 * tool_size(pressing);
  for (const View& view : {View{"near", "from near", near, near_arrow},
                           View{"whole", "as a whole", whole, 0.2 * extent(rest)}}) {
    const auto before = draw_body(world, id, rest, view.camera, view.arrow, outputs),
               then = draw_body(world, id, pressed, view.camera, view.arrow, outputs);
    if (!before || !then) return Done{};
    const Status status =
        add_picture(outputs, fmt::format("{}-{}.png", body.name, view.name),
                    fmt::format("{} {}, before and under the largest force", body.name, view.caption),
                    side_by_side({*before, *then}, {"before", force}), true);
    if (!status) return status;
  }
  const Camera above = camera_at_tool(pressed, pressing, true, aspect);
  if (const Status s =
          add_colored(body, SkinColor::kDisplacement, "displacement", "displacement", above, outputs);
      !s)
    return s;
  if (id.kind != BodyKind::kSfem) return Done{};  // the others know no pressure
  return add_colored(body, SkinColor::kPressure, "pressure", "contact pressure", above, outputs);
}

}  // namespace

void show_touched(const Exec& exec, World& world) {
  for (SfemBody& body : world.sfem_bodies) {
    const Timer timer;
    body.shown = shown_surface(exec, body, time_of(world));
    body.surface_seconds.push_back(timer.seconds());
  }
  for (RhombusBody& body : world.rhombus_bodies) {
    const Timer timer;
    body.shown = shown_surface(exec, body, world.tools, time_of(world));
    body.surface_seconds.push_back(timer.seconds());
  }
  for (LatticeBody& body : world.lattice_bodies) body.shown = shown_tools(body, time_of(world));
}

void add_touched(const World& world, const Scene& scene, SkinColor color, const ColorScale* scale,
                 PictureParts& parts) {
  const bool known = color == SkinColor::kDisplacement || color == SkinColor::kPressure;
  for_each_touched(world, [&](BodyId id, const auto& body) {
    if (!keeps_surface(id, body)) return;
    add_body(body.shown, tool_meshes(world, body, body.shown), {usual_force(scene, id), 0.2 * extent(body)},
             known ? color : SkinColor::kNone, known ? scale : nullptr, parts);
  });
}

Status write_touched_meshes(const World& world, Outputs& outputs) {
  return try_each_touched(world, [&](BodyId id, const TouchedBody& body) -> Status {
    if (id.kind == BodyKind::kLattice) return Done{};  // outputs_skin.cpp
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", body.name, world.frame);
    std::vector<VertexField> fields{length_field("displacement", body.shown.displacement),
                                    vertex_field("pressure [Pa]", body.shown.pressure)};
    const std::vector<float> numbers(body.shown.mesh_vertex.begin(), body.shown.mesh_vertex.end());
    if (!numbers.empty()) fields.push_back(vertex_field("mesh vertex", numbers));
    const Status status = write_vtu(outputs.folder / file, deformed_mesh(body.shown, SkinColor::kNone),
                                    fields, outputs.scene->output.mesh_space);
    if (status) outputs.series.push_back({time_of(world), file, body.name});
    return status;
  });
}

Status finish_touched_outputs(const World& world, Outputs& outputs) {
  const Status drawn = try_each_touched(world, [&](BodyId id, const TouchedBody& body) -> Status {
    if (const Status status = add_pressed_pictures(world, id, body, outputs); !status) return status;
    if (!outputs.scene->output.obj || !(body.largest_force > 0) || id.kind == BodyKind::kLattice)
      return Done{};
    const std::string file = body.name + ".obj";
    outputs.facts.files.push_back(file);
    const TriMesh mesh = deformed_mesh(body.deepest, SkinColor::kNone);
    return write_obj(outputs.folder / file, mesh, outputs.scene->output.mesh_space);
  });
  if (!drawn) return drawn;
  if (world.tools.empty()) return Done{};
  if (const Status status = write_forces(outputs.folder / "forces.csv", world.tools); !status) return status;
  outputs.facts.files.push_back("forces.csv");
  return Done{};
}

}  // namespace turgor
