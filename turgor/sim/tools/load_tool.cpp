#include "turgor/sim/tools/load_tool.hpp"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/body_location.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/geometry/signed_distance.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/sim/tools/tool_mesh.hpp"

namespace turgor {

namespace {

/// Shape of a tool for contact and for pictures.
struct MadeShape {
  contact::Shape shape;
  TriMesh mesh;
  std::optional<contact::Forceps> forceps;
  std::optional<contact::Needle> needle = {};
};

/// Forceps from a surface with two components, the jaws.
Result<contact::Forceps> make_forceps(const ForcepsTool& given) {
  if (given.file.empty())
    return contact::build_forceps(phantom_forceps_half(false), phantom_forceps_half(true), given.opening);
  Result<ReadSurface> read = read_surface(given.file, given.scale);
  if (!read) return read.error();
  Result<contact::Forceps> made = contact::build_forceps(read->mesh, given.opening);
  if (!made) return Error{fmt::format("{}: {}", given.file.string(), made.error().message)};
  return made;
}

Result<MadeShape> make_shape(const ToolShape& given) {
  // analytic shapes
  if (const auto* ball = std::get_if<BallTool>(&given))
    return MadeShape{contact::Sphere{ball->radius}, capsule_mesh(ball->radius, 0)};
  if (const auto* rod = std::get_if<RodTool>(&given))
    return MadeShape{contact::Capsule{rod->radius, rod->half_length},
                     capsule_mesh(rod->radius, rod->half_length)};
  // forceps: distance field of the closed jaws
  if (const auto* jaws = std::get_if<ForcepsTool>(&given)) {
    Result<contact::Forceps> forceps = make_forceps(*jaws);
    if (!forceps) return forceps.error();
    TriMesh closed = contact::forceps_mesh(*forceps, 0);
    Result<contact::Shape> shape = contact::mesh_shape(closed);
    if (!shape) return Error{fmt::format("the forceps: {}", shape.error().message)};
    return MadeShape{std::move(*shape), std::move(closed), std::move(*forceps)};
  }
  if (const auto* given_needle = std::get_if<NeedleTool>(&given)) {
    const contact::Needle& needle = given_needle->needle;
    MadeShape made{contact::Sphere{needle.diameter / 2},
                   needle_mesh(needle.diameter, contact::cone_length(needle), needle.length),
                   {}};
    made.needle = needle;
    return made;
  }
  // mesh file
  const MeshTool& file = std::get<MeshTool>(given);
  Result<ReadSurface> read = read_surface(file.file, file.scale);
  if (!read) return read.error();
  Result<contact::Shape> shape = contact::mesh_shape(read->mesh);
  if (!shape) return Error{fmt::format("{}: {}", file.file.string(), shape.error().message)};
  return MadeShape{std::move(*shape), std::move(read->mesh)};
}

/// Width of a tool [m]. For a capsule this is its thickness, since it may be longer than the body.
double width(const ToolShape& given, const contact::Shape& shape) {
  if (const auto* rod = std::get_if<RodTool>(&given)) return 2 * rod->radius;
  if (const auto* jaws = std::get_if<ForcepsTool>(&given)) return jaws->opening;
  return 2 * contact::bounding_radius(shape);
}

/// Distance from the tool's origin down to its lowest point; negative if that is above the origin [m].
double tip(const TriMesh& mesh) {
  TURGOR_CHECK(!mesh.vertices.empty(), "a tool has a mesh");
  float lowest = mesh.vertices.front().z;
  for (const Vec3 x : mesh.vertices) lowest = std::min(lowest, x.z);
  return -double(lowest);
}

/// `reach`: half of the tool's width, at most of the body's [m].
Result<ToolPath> make_path(const ToolScene& scene, const TouchingTool& tool, const RestSurface& surface,
                           double reach) {
  if (const auto* rows = std::get_if<GivenPath>(&scene.motion)) return ToolPath{rows->rows, rows->smooth};
  if (const auto* press = std::get_if<Press>(&scene.motion))
    return press_path(surface, *press, tip(tool.mesh), reach);
  if (const auto* grasp = std::get_if<Grasp>(&scene.motion))
    return grasp_path(surface, *grasp, tip(tool.mesh), reach);
  if (std::holds_alternative<HandFile>(scene.motion)) return path_of(tool.hand);
  const PathFile& file = std::get<PathFile>(scene.motion);
  Result<std::vector<PathRow>> rows = read_path_rows(file.file);
  if (!rows) return rows.error();
  return ToolPath{std::move(*rows), file.smooth};
}

/// Adds a note if a target is farther from the surface than the tool's width; targets are moved to the
/// surface.
void note_moved(const std::string& key, Vec3d target, const RestSurface& surface, const std::string& body,
                double width, std::vector<std::string>& notes) {
  const Vec3d point = sample_surface(surface, target, false, width).point;
  TURGOR_CHECK(width > 0, "a tool has a width");
  const double distance = norm(point - target);
  if (distance > width)
    notes.push_back(fmt::format("{} = {} is not on {} and was moved to its nearest point; {}", key,
                                position_text(target), body,
                                describe_location(box_around(surface.vertices), point, distance)));
}

void note_moved_targets(const ToolScene& scene, const std::string& body, const RestSurface& surface,
                        double width, std::vector<std::string>& notes) {
  if (const auto* press = std::get_if<Press>(&scene.motion); press && !press->by_fraction) {
    note_moved("press.at", press->at, surface, body, width, notes);
    if (press->slide > 0) note_moved("press.to", press->to, surface, body, width, notes);
  }
  if (const auto* grasp = std::get_if<Grasp>(&scene.motion); grasp && !grasp->by_fraction)
    note_moved("grasp.at", grasp->at, surface, body, width, notes);
}

/// Distance from a tip inside of a body to its surface along the shaft (Möller and Trumbore 1997); 0 = none
/// [m].
double shaft_inside(const RestSurface& surface, Vec3d tip, Vec3d up) {
  double nearest = 0;
  for (const Int3 t : surface.triangles) {
    const auto x = [&](int v) { return surface.vertices[std::size_t(v)]; };
    const Vec3d ab = x(t.y) - x(t.x), ac = x(t.z) - x(t.x), p = cross(up, ac), s = tip - x(t.x),
                q = cross(s, ab);
    const double det = dot(ab, p);
    if (det == 0) continue;
    const double u = dot(s, p) / det, v = dot(up, q) / det, distance = dot(ac, q) / det;
    if (u < 0 || v < 0 || u + v > 1 || distance <= 0) continue;
    nearest = nearest > 0 ? std::min(nearest, distance) : distance;
  }
  return nearest;
}

/// Refuses a needle that starts inside of the body, or that is shorter than its path into it.
Status check_needle_path(const TouchingTool& tool, const std::string& body, const RestSurface& surface) {
  const SignedDistance distance = distance_to_surface(mesh_of(surface.vertices, surface.triangles));
  for (std::size_t r = 0; r < tool.path.rows.size(); r++) {
    const PathRow& row = tool.path.rows[r];
    const double below = -distance.at(row.position);
    if (r == 0 && below > 0)
      return Error{
          fmt::format("expected a needle that starts outside of {}, found its tip {:.4g} m below the surface "
                      "at {:.4g} s",
                      body, below, row.time)};
    const double inside =
        below > 0 ? shaft_inside(surface, row.position, axes_of(row.orientation).column[2]) : 0;
    if (inside > tool.tool.needle->length)
      return Error{
          fmt::format("expected a path into {} of at most the needle's length, {:.4g} m, found {:.4g} m at "
                      "{:.4g} s",
                      body, tool.tool.needle->length, inside, row.time)};
  }
  return Done{};
}

}  // namespace

Result<TouchingTool> load_tool_shape(const ToolScene& scene) {
  TouchingTool tool;
  tool.name = scene.name, tool.body = scene.body;
  Result<MadeShape> made = make_shape(scene.shape);
  if (!made) return Error{fmt::format("{}: {}", scene.source_location, made.error().message)};
  tool.tool = {std::move(made->shape), scene.friction, made->needle};
  tool.mesh = std::move(made->mesh);
  tool.forceps = std::move(made->forceps);
  if (const auto* jaws = std::get_if<ForcepsTool>(&scene.shape)) tool.closing_time = jaws->closing;
  return tool;
}

Result<TouchingTool> load_tool(const ToolScene& scene, const std::string& body, const RestSurface& surface) {
  Result<TouchingTool> loaded = load_tool_shape(scene);
  if (!loaded) return loaded.error();
  TouchingTool tool = std::move(*loaded);

  TURGOR_CHECK(!surface.vertices.empty(), "a touched body has a surface");
  // plausible size; the report warns of a tool larger than every body (odd_sizes)
  const Box box = box_around(surface.vertices);
  const Vec3d extent = box.high - box.low;
  const double body_width = std::max({extent.x, extent.y, extent.z}),
               tool_width = width(scene.shape, tool.tool.shape);
  constexpr double kMostWidths = 10;  // beyond, lengths are in another unit
  const double across = tool.tool.needle ? tool.tool.needle->diameter : tool_width;  // a needle may be long
  if (across >= kMostWidths * body_width)
    return Error{
        fmt::format("{}: the tool is {:.4g} m wide, the body {} {:.4g} m; expected a tool of less than {} "
                    "times the body's width (are lengths in meters?)",
                    scene.source_location, across, body, body_width, kMostWidths)};

  // motion
  if (const auto* recorded = std::get_if<HandFile>(&scene.motion)) {
    Result<std::vector<HandRow>> hand = read_hand(recorded->file, scene.name);
    if (!hand) return Error{fmt::format("{}: {}", scene.source_location, hand.error().message)};
    tool.hand = std::move(*hand);
  }
  Result<ToolPath> path = make_path(scene, tool, surface, 0.5 * std::min(tool_width, body_width));
  if (!path) return Error{fmt::format("{}: {}", scene.source_location, path.error().message)};
  tool.path = std::move(*path);

  TURGOR_CHECK(!tool.path.rows.empty() || !tool.hand.empty(), "a loaded tool has a path");
  if (tool.tool.needle)
    if (const Status status = check_needle_path(tool, body, surface); !status)
      return Error{fmt::format("{}: {}", scene.source_location, status.error().message)};
  // log and notes
  tool.samples.start(command_at(tool, 0));
  note_moved_targets(scene, body, surface, tool_width, tool.notes);
  return tool;
}

}  // namespace turgor
