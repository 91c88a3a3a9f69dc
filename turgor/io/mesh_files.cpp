#include "turgor/io/mesh_files.hpp"

#include <bit>
#include <cstdint>
#include <iterator>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/file.hpp"

namespace turgor {

namespace {

std::string xml_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

const char* byte_order() { return std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian"; }

/// The binary end of a .vtu: blocks, each preceded by its size in bytes.
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

std::string cell_arrays(Appended& appended, std::size_t count) {
  constexpr std::uint8_t kVtkTriangle = 5;
  std::vector<std::int64_t> ends(count);
  for (std::size_t t = 0; t < count; t++) ends[t] = std::int64_t(3 * (t + 1));
  const std::vector<std::uint8_t> types(count, kVtkTriangle);
  return data_array(appended, "Int64", "offsets", 1, ends.data(), ends.size() * sizeof ends[0]) +
         data_array(appended, "UInt8", "types", 1, types.data(), types.size());
}

}  // namespace

Status write_obj(const std::filesystem::path& path, const TriMesh& mesh) {
  std::string text = "# Turgor: metres, patient frame LPS (x to the left, y to the back, z to the head)\n";
  const auto out = std::back_inserter(text);
  const bool normals = mesh.normals.size() == mesh.vertices.size();
  for (const Vec3 v : mesh.vertices) fmt::format_to(out, "v {:.6f} {:.6f} {:.6f}\n", v.x, v.y, v.z);
  if (normals)
    for (const Vec3 n : mesh.normals) fmt::format_to(out, "vn {:.4f} {:.4f} {:.4f}\n", n.x, n.y, n.z);
  for (const auto [a, b, c] : mesh.triangles) {
    if (normals)
      fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
    else
      fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return write_file(path, text);
}

Status write_vtu(const std::filesystem::path& path, const TriMesh& mesh,
                 const std::vector<VertexField>& fields) {
  const std::size_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  Appended appended;
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- Turgor: metres, patient frame LPS -->\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n"
      "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>\n",
      byte_order(), vertices, triangles);
  if (mesh.normals.size() == vertices) text += field_array(appended, vertex_field("normal", mesh.normals));
  for (const VertexField& field : fields) {
    TURGOR_ASSERT(field.values.size() == vertices * std::size_t(field.components),
                  "a field has one value a vertex");
    text += field_array(appended, field);
  }
  text += "</PointData>\n<Points>\n" + field_array(appended, vertex_field("points", mesh.vertices));
  std::vector<std::int32_t> corners;
  for (const auto [a, b, c] : mesh.triangles) corners.insert(corners.end(), {a, b, c});
  text += "</Points>\n<Cells>\n";
  text +=
      data_array(appended, "Int32", "connectivity", 1, corners.data(), corners.size() * sizeof(std::int32_t));
  text += cell_arrays(appended, triangles);
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  return write_file(path, text + appended.bytes + "\n</AppendedData>\n</VTKFile>\n");
}

Status write_pvd(const std::filesystem::path& path, const std::vector<PvdEntry>& entries) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"{}\">\n<Collection>\n",
      byte_order());
  for (const PvdEntry& entry : entries)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" name=\"{}\" file=\"{}\"/>\n", entry.time,
                        xml_text(entry.part), xml_text(entry.file));
  return write_file(path, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace turgor
