#include "turgor/io/mesh/mesh_files.hpp"

#include <bit>
#include <cstdint>
#include <iterator>
#include <numeric>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/files/xml_text.hpp"
#include "turgor/io/mesh/mesh_space.hpp"

namespace turgor {

namespace {

const char* byte_order() { return std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian"; }

/// Appended binary data of a .vtu: blocks, each preceded by its size in bytes.
struct Appended {
  std::string bytes;

  /// Adds a block and returns its offset.
  std::size_t add(const void* data, std::uint64_t size) {
    const std::size_t offset = bytes.size();
    bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
    if (size > 0) bytes.append(static_cast<const char*>(data), size);
    return offset;
  }
};

std::string data_array(Appended& appended, const char* type, std::string_view name, int components,
                       const void* data, std::size_t size) {
  return fmt::format(
      R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="appended" offset="{}"/>)"
      "\n",
      type, xml_text(name), components, appended.add(data, size));
}

std::string field_array(Appended& appended, const VertexField& field) {
  return data_array(appended, "Float32", field.name, field.components, field.values.data(),
                    field.values.size_bytes());
}

std::string field_arrays(Appended& appended, const std::vector<VertexField>& fields, std::size_t count,
                         MeshSpace space) {
  std::string text;
  for (const VertexField& field : fields) {
    TURGOR_ASSERT(field.values.size() == count * std::size_t(field.components),
                  "a field has one value a vertex, or an element");
    const std::vector<float> values = io::values_in_space(field, space);
    text += field_array(appended, {io::name_in_space(field, space), field.components, values});
  }
  return text;
}

/// A text as an array of the whole file: VTK stores its bytes as numbers, with a terminating zero.
std::string text_array(std::string_view name, std::string_view text) {
  std::string bytes;
  for (const char c : text) bytes += fmt::format("{} ", int(static_cast<unsigned char>(c)));
  return fmt::format(R"(<Array type="String" Name="{}" NumberOfTuples="1" format="ascii">{}0</Array>)"
                     "\n",
                     name, bytes);
}

/// Cells of one type with `each` corners.
std::string cell_arrays(Appended& appended, const std::vector<std::int32_t>& corners, int each,
                        std::uint8_t vtk_type) {
  const std::size_t count = corners.size() / std::size_t(each);
  std::vector<std::int64_t> ends(count);
  for (std::size_t c = 0; c < count; c++) ends[c] = std::int64_t(std::size_t(each) * (c + 1));
  const std::vector<std::uint8_t> types(count, vtk_type);
  return "<Cells>\n" +
         data_array(appended, "Int32", "connectivity", 1, corners.data(),
                    corners.size() * sizeof(std::int32_t)) +
         data_array(appended, "Int64", "offsets", 1, ends.data(), ends.size() * sizeof ends[0]) +
         data_array(appended, "UInt8", "types", 1, types.data(), types.size()) + "</Cells>\n";
}

std::string vtu_begin(std::size_t points, std::size_t cells, MeshSpace space) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- Turgor: {} -->\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n{}{}</FieldData>\n"
      "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      io::space_text(space), byte_order(), text_array("SPACE", io::frame_name(space)),
      text_array("unit", unit_name(space)), points, cells);
}

std::string vtu_end(const Appended& appended) {
  return "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_" + appended.bytes +
         "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace

Status write_obj(const std::filesystem::path& path, const TriMesh& mesh, MeshSpace space,
                 std::span<const MeshGroup> groups) {
  std::string text = fmt::format("# Turgor: {}\n# SPACE={}\n", io::space_text(space), io::frame_name(space));
  const auto out = std::back_inserter(text);
  const bool normals = mesh.normals.size() == mesh.vertices.size();
  for (const Vec3 v : io::in_space(mesh.vertices, space))
    fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}\n", v.x, v.y, v.z);  // the same bits when read again
  if (normals)
    for (const Vec3 n : io::to_file_axes(mesh.normals, space))
      fmt::format_to(out, "vn {:.4f} {:.4f} {:.4f}\n", n.x, n.y, n.z);
  for (std::size_t t = 0; t < mesh.triangles.size(); t++) {
    const auto [a, b, c] = mesh.triangles[t];
    for (const MeshGroup& group : groups)
      if (group.begin == t) fmt::format_to(out, "g {}\n", group.name);
    if (normals)
      fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
    else
      fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return write_file(path, text);
}

Status write_vtu(const std::filesystem::path& path, const TriMesh& mesh,
                 const std::vector<VertexField>& fields, MeshSpace space) {
  constexpr std::uint8_t kVtkTriangle = 5;
  const std::size_t vertices = mesh.vertices.size();
  Appended appended;
  std::string text = vtu_begin(vertices, mesh.triangles.size(), space) + "<PointData>\n";
  if (mesh.normals.size() == vertices)
    text += field_array(appended, vertex_field("normal", io::to_file_axes(mesh.normals, space)));
  text += field_arrays(appended, fields, vertices, space);
  const std::vector<Vec3> positions = io::in_space(mesh.vertices, space);
  text += "</PointData>\n<Points>\n" + field_array(appended, vertex_field("points", positions));
  std::vector<std::int32_t> corners;
  for (const auto [a, b, c] : mesh.triangles) corners.insert(corners.end(), {a, b, c});
  text += "</Points>\n" + cell_arrays(appended, corners, 3, kVtkTriangle);
  return write_file(path, text + vtu_end(appended));
}

Status write_points(const std::filesystem::path& path, const std::vector<Vec3>& points,
                    const std::vector<VertexField>& fields, MeshSpace space) {
  constexpr std::uint8_t kVtkVertex = 1;
  Appended appended;
  std::string text = vtu_begin(points.size(), points.size(), space) + "<PointData>\n";
  text += field_arrays(appended, fields, points.size(), space);
  const std::vector<Vec3> positions = io::in_space(points, space);
  text += "</PointData>\n<Points>\n" + field_array(appended, vertex_field("points", positions));
  std::vector<std::int32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0);
  text += "</Points>\n" + cell_arrays(appended, corners, 1, kVtkVertex);
  return write_file(path, text + vtu_end(appended));
}

Status write_vtu(const std::filesystem::path& path, const SolidMesh& mesh,
                 const std::vector<VertexField>& vertex_fields,
                 const std::vector<VertexField>& element_fields) {
  constexpr std::uint8_t kVtkTetra = 10, kVtkHexahedron = 12;
  const std::size_t vertices = mesh.vertices.size(), count = element_count(mesh);
  std::vector<std::int32_t> regions(count);
  for (std::size_t e = 0; e < count; e++) regions[e] = region(mesh, e);
  Appended appended;
  std::string text = vtu_begin(vertices, count, {}) + "<PointData>\n";
  text += field_arrays(appended, vertex_fields, vertices, {}) + "</PointData>\n<CellData>\n";
  text += data_array(appended, "Int32", "region", 1, regions.data(), count * sizeof regions[0]);
  text += field_arrays(appended, element_fields, count, {}) + "</CellData>\n<Points>\n";
  text += data_array(appended, "Float64", "points", 3, mesh.vertices.data(), vertices * sizeof(Vec3d));
  const std::uint8_t type = mesh.corners == 4 ? kVtkTetra : kVtkHexahedron;
  text += "</Points>\n" + cell_arrays(appended, mesh.elements, mesh.corners, type);
  return write_file(path, text + vtu_end(appended));
}

Status write_pvd(const std::filesystem::path& path, const std::vector<PvdEntry>& entries, MeshSpace space) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- Turgor: {} -->\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"{}\">\n<Collection>\n",
      io::space_text(space), byte_order());
  for (const PvdEntry& entry : entries)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" name=\"{}\" file=\"{}\"/>\n", entry.time,
                        xml_text(entry.body), xml_text(entry.file));
  return write_file(path, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace turgor
