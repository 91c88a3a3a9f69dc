// Writes surfaces to files at every snapshot and at the end.
#include <fmt/format.h>

#include "turgor/pictures/animated_surfaces.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/sim/report/report_skin.hpp"

namespace turgor {

namespace {

/// Values of fields that a body does not store.
struct FieldValues {
  std::vector<float> mesh_vertex, largest_stretch;
};

/// The fields refer to the body and to `values`, which receives the mesh numbers of its vertices and the
/// largest stretch of skin.
std::vector<VertexField> fields_of(const BodySnapshot& body, FieldValues& values) {
  std::vector<VertexField> fields{length_field("displacement", body.displacement)};
  if (!body.stretch.empty()) fields.push_back(vertex_field("area strain [1]", body.stretch));
  if (!body.pressure.empty()) fields.push_back(vertex_field("pressure [Pa]", body.pressure));
  values.largest_stretch = skin_stretches(body);
  if (!values.largest_stretch.empty())
    fields.push_back(vertex_field("largest stretch [1]", values.largest_stretch));
  values.mesh_vertex.assign(body.mesh_vertex.begin(), body.mesh_vertex.end());
  if (!values.mesh_vertex.empty()) fields.push_back(vertex_field("mesh vertex", values.mesh_vertex));
  return fields;
}

/// Pressed bodies are written under the largest force, because tools are often retracted at the end.
const BodySnapshot& worth_keeping(const BodySnapshot& body, const std::vector<Pressed>& pressed) {
  for (const Pressed& one : pressed)
    if (one.id == body.id && one.force > 0 && body.look != Look::kSkin) return one.body;
  return body;
}

/// Separate group for the walls of wounds, if there are any.
std::vector<MeshGroup> groups_of(const BodySnapshot& body) {
  if (body.wall_begin >= body.triangles.size()) return {};
  return {{"skin", 0}, {"wound", body.wall_begin}};
}

/// VTKHDF series of that file name.
Result<VtkHdfSeries*> series_of(const std::string& name, Outputs& outputs) {
  const std::string file = "meshes/" + name + ".vtkhdf";
  const auto found = outputs.vtkhdf.find(file);
  if (found != outputs.vtkhdf.end()) return &found->second;
  Result<VtkHdfSeries> made = VtkHdfSeries::create(outputs.folder / file, outputs.scene->output.mesh_space);
  if (!made) return made.error();
  return &outputs.vtkhdf.emplace(file, std::move(*made)).first->second;
}

/// Writes a mesh of a snapshot to the files that the scene requests; `body` is its name in ParaView.
Status write_mesh(const WorldSnapshot& snapshot, const std::string& name, const std::string& body,
                  const TriMesh& mesh, const std::vector<VertexField>& fields, Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  if (output.meshes) {
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", name, snapshot.frame);
    const Status status = write_vtu(outputs.folder / file, mesh, fields, output.mesh_space);
    if (!status) return status;
    outputs.series.push_back({snapshot.time, file, body});
  }
  if (!output.vtkhdf) return Done{};
  const Result<VtkHdfSeries*> series = series_of(name, outputs);
  return series ? (*series)->add(snapshot.time, mesh, fields) : series.error();
}

/// Writes a point for each tool with the force on it.
Status write_forces(const WorldSnapshot& snapshot, const std::vector<Vec3>& positions,
                    const std::vector<Vec3>& forces, Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  VertexField force = vertex_field("force on the tool [N]", forces);
  force.is_direction = true;
  if (output.meshes) {
    const std::string file = fmt::format("meshes/forces/on-tools-{:04}.vtu", snapshot.frame);
    outputs.series.push_back({snapshot.time, file, "forces on tools"});
    const Status status = write_points(outputs.folder / file, positions, {force}, output.mesh_space);
    if (!status) return status;
  }
  if (!output.vtkhdf) return Done{};
  const Result<VtkHdfSeries*> series = series_of("forces/on-tools", outputs);
  return series ? (*series)->add_points(snapshot.time, positions, {force}) : series.error();
}

/// Writes the tools' meshes, and the forces on them.
Status write_tools(const WorldSnapshot& snapshot, Outputs& outputs) {
  std::vector<Vec3> positions, forces;
  for (const ToolSnapshot& tool : snapshot.tools) {
    const Status status =
        write_mesh(snapshot, "tools/" + tool.name, tool.name, posed_mesh(tool), {}, outputs);
    if (!status) return status;
    positions.push_back(Vec3(tool.pose.position));
    forces.push_back(Vec3(tool.force));
  }
  return positions.empty() ? Done{} : write_forces(snapshot, positions, forces, outputs);
}

/// Adds the snapshot to the animation. If only glTF is requested and cannot hold it, the animation ends with
/// a warning, and its memory is freed.
void extend_animation(const WorldSnapshot& snapshot, Outputs& outputs, std::uint64_t most_glb_bytes) {
  const OutputScene& output = outputs.scene->output;
  if (outputs.animation_ended || (!output.usd && !output.gltf)) return;
  add_surfaces(snapshot, outputs.animation);
  if (output.usd) return;
  const Status fits = check_glb(outputs.animation, most_glb_bytes);
  if (fits) return;
  outputs.facts.warnings.push_back(
      fmt::format("no glTF: {} (at {:.3f} s)", fits.error().message, snapshot.time));
  outputs.animation = {};
  outputs.animation_ended = true;
}

}  // namespace

Status write_meshes(const WorldSnapshot& snapshot, Outputs& outputs, std::uint64_t most_glb_bytes) {
  extend_animation(snapshot, outputs, most_glb_bytes);
  if (!outputs.scene->output.meshes && !outputs.scene->output.vtkhdf) return Done{};
  const AddTime time(outputs.facts.file_seconds);
  for (const BodySnapshot& body : snapshot.bodies) {
    FieldValues values;
    const std::vector<VertexField> fields = fields_of(body, values);
    const Status status = write_mesh(snapshot, body.name, body.name, surface_mesh(body), fields, outputs);
    if (!status) return status;
  }
  return write_tools(snapshot, outputs);
}

Status finish_meshes(Outputs& outputs) {
  for (auto& [file, series] : outputs.vtkhdf) {
    if (const Status status = series.close(); !status) return status;
    outputs.facts.files.push_back(file);
  }
  if (!outputs.scene->output.meshes) return Done{};
  outputs.facts.files.push_back("meshes.pvd");
  return write_pvd(outputs.folder / "meshes.pvd", outputs.series, outputs.scene->output.mesh_space);
}

void finish_animation(Outputs& outputs, std::uint64_t most_glb_bytes) {
  const OutputScene& output = outputs.scene->output;
  if (outputs.animation_ended || (!output.usd && !output.gltf)) return;
  const AddTime time(outputs.facts.file_seconds);
  SurfaceAnimation& animation = outputs.animation;
  animation.frame_rate = outputs.scene->frame_rate;
  remove_empty_surfaces(animation);
  const auto finish = [&](const Status& written, const char* file, const char* format) {
    if (written)
      outputs.facts.files.push_back(file);
    else
      outputs.facts.warnings.push_back(fmt::format("no {}: {}", format, written.error().message));
  };
  constexpr const char *kUsd = "surfaces.usda", *kGlb = "surfaces.glb";
  if (output.usd) finish(write_usda(outputs.folder / kUsd, animation), kUsd, "USD");
  if (output.gltf) finish(write_glb(outputs.folder / kGlb, animation, most_glb_bytes), kGlb, "glTF");
}

Status write_objs(const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed, Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  for (const BodySnapshot& body : snapshot.bodies) {
    const std::string file = body.name + ".obj";
    const BodySnapshot& kept = worth_keeping(body, pressed);
    const Status status = write_obj(outputs.folder / file, surface_mesh(kept),
                                    outputs.scene->output.mesh_space, groups_of(kept));
    if (!status) return status;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

}  // namespace turgor
