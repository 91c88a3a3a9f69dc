// Writing of meshes: Wavefront OBJ for modeling programs, VTK's .vtu (XML, raw binary) and .pvd time series
// for ParaView. Coordinates are meters in the patient frame LPS by default. The files state unit and frame in
// a comment and, as 3D Slicer reads it, under the name SPACE.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Unit and axes of a file. LPS: x to the left, y to the back, z to the head. RAS: x to the right, y to the
/// front, a half turn about z.
struct MeshSpace {
  bool is_mm = false;
  bool is_ras = false;
};
inline const char* unit_name(MeshSpace space) { return space.is_mm ? "mm" : "m"; }

/// A named range of triangles: from `begin` to the beginning of the next group.
struct MeshGroup {
  std::string name;
  std::size_t begin = 0;
};

/// Writes vertices, normals if the mesh has them, and triangles, by group if there are any.
Status write_obj(const std::filesystem::path& path, const TriMesh& mesh, MeshSpace space = {},
                 std::span<const MeshGroup> groups = {});

/// A quantity at every vertex, or in every element of a solid mesh: `components` numbers each, 1 or 3.
struct VertexField {
  std::string name;  // with its unit, as ParaView shows it; without a unit if it is a length
  int components = 1;
  std::span<const float> values;
  bool is_length = false;  // [m]: written in the file's unit, whose name is added, and along the file's axes
  bool is_direction = false;  // of another unit, along the file's axes
};
inline VertexField vertex_field(std::string name, const std::vector<Vec3>& values) {
  return {std::move(name), 3, {values.empty() ? nullptr : &values.front().x, values.size() * 3}};
}
inline VertexField vertex_field(std::string name, const std::vector<float>& values) {
  return {std::move(name), 1, values};
}
template <class Value>
VertexField length_field(std::string name, const std::vector<Value>& values) {
  VertexField field = vertex_field(std::move(name), values);
  field.is_length = true;
  return field;
}

/// Writes the mesh, its normals if it has them, and the fields.
Status write_vtu(const std::filesystem::path& path, const TriMesh& mesh,
                 const std::vector<VertexField>& fields, MeshSpace space = {});
/// Writes a solid mesh in meters and LPS, with its regions, vertex fields and element fields; read_solid
/// reads it.
Status write_vtu(const std::filesystem::path& path, const SolidMesh& mesh,
                 const std::vector<VertexField>& vertex_fields,
                 const std::vector<VertexField>& element_fields);

/// Writes points without a surface, with fields: input of ParaView's glyphs.
Status write_points(const std::filesystem::path& path, const std::vector<Vec3>& points,
                    const std::vector<VertexField>& fields, MeshSpace space = {});

/// One time step of a time series.
struct PvdEntry {
  double time = 0;   // [s]
  std::string file;  // relative to the .pvd
  std::string body;  // name of the body
};
Status write_pvd(const std::filesystem::path& path, const std::vector<PvdEntry>& entries,
                 MeshSpace space = {});

}  // namespace turgor
