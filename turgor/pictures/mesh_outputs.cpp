// Surfaces in files: as they lie at every snapshot, and at the end.
#include <fmt/format.h>

#include "turgor/pictures/outputs.hpp"

namespace turgor {

namespace {

/// They look at the body and at `numbers`, which gets its vertices' numbers in the mesh.
std::vector<VertexField> fields_of(const ShownBody& body, std::vector<float>& numbers) {
  std::vector<VertexField> fields{length_field("displacement", body.displacement)};
  if (!body.stretch.empty()) fields.push_back(vertex_field("area strain [1]", body.stretch));
  if (!body.pressure.empty()) fields.push_back(vertex_field("pressure [Pa]", body.pressure));
  numbers.assign(body.mesh_vertex.begin(), body.mesh_vertex.end());
  if (!numbers.empty()) fields.push_back(vertex_field("mesh vertex", numbers));
  return fields;
}

/// What tools press is worth looking at under the largest force: in the end they are away.
const ShownBody& worth_keeping(const ShownBody& body, const std::vector<Pressed>& pressed) {
  for (const Pressed& one : pressed)
    if (one.id == body.id && one.force > 0 && body.look != Look::kSkin) return one.body;
  return body;
}

/// Walls of wounds apart from the skin, where there are any.
std::vector<MeshGroup> groups_of(const ShownBody& body) {
  if (body.wall_begin >= body.triangles.size()) return {};
  return {{"skin", 0}, {"wound", body.wall_begin}};
}

/// Tools where they are, and a point for each with the force on it.
Status write_tools(const ShownWorld& shown, Outputs& outputs) {
  const MeshSpace space = outputs.scene->output.mesh_space;
  std::vector<Vec3> places, forces;
  for (const ShownTool& tool : shown.tools) {
    const std::string file = fmt::format("meshes/tools/{}-{:04}.vtu", tool.name, shown.frame);
    if (const Status status = write_vtu(outputs.folder / file, placed_mesh(tool), {}, space); !status)
      return status;
    outputs.series.push_back({shown.time, file, tool.name});
    places.push_back(Vec3(tool.pose.position));
    forces.push_back(Vec3(tool.force));
  }
  if (places.empty()) return Done{};
  VertexField force = vertex_field("force on the tool [N]", forces);
  force.is_direction = true;
  const std::string file = fmt::format("meshes/forces/on-tools-{:04}.vtu", shown.frame);
  outputs.series.push_back({shown.time, file, "forces on tools"});
  return write_points(outputs.folder / file, places, {force}, space);
}

}  // namespace

Status write_meshes(const ShownWorld& shown, Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  for (const ShownBody& body : shown.bodies) {
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", body.name, shown.frame);
    std::vector<float> numbers;
    const Status status = write_vtu(outputs.folder / file, shown_mesh(body), fields_of(body, numbers),
                                    outputs.scene->output.mesh_space);
    if (!status) return status;
    outputs.series.push_back({shown.time, file, body.name});
  }
  return write_tools(shown, outputs);
}

Status write_objs(const ShownWorld& shown, const std::vector<Pressed>& pressed, Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  for (const ShownBody& body : shown.bodies) {
    const std::string file = body.name + ".obj";
    const ShownBody& kept = worth_keeping(body, pressed);
    const Status status =
        write_obj(outputs.folder / file, shown_mesh(kept), outputs.scene->output.mesh_space, groups_of(kept));
    if (!status) return status;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

}  // namespace turgor
