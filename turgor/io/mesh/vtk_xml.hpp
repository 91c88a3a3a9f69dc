// What VTK's XML formats have in common (.vtu, .vtp): the file parsed by pugixml, and its arrays as text,
// base64 or raw bytes. Raw appended bytes are no XML: the text is cut before them. Internal to io/.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "turgor/core/vec.hpp"
#include "turgor/io/mesh/mesh_cursor.hpp"

namespace turgor::io {

struct VtkXml {
  const std::filesystem::path& path;
  std::string_view bytes;
  std::string_view appended;  // from behind its "_"
  bool is_appended_base64 = false;
  pugi::xml_document xml;
};

/// Parses the file's bytes. Error: no XML, another type than asked for (as "PolyData"), an unknown
/// compression.
Status parse_vtk_xml(VtkXml& file, std::string_view type);
/// "VTU", "VTU (compressed)".
std::string vtk_xml_format(const VtkXml& file, std::string_view name);
Error error_at(const VtkXml& file, pugi::xml_node node, std::string_view message);

/// A number of points or cells of a piece, within what the file can hold even when compressed.
Result<std::size_t> read_size(const VtkXml& file, pugi::xml_node piece, const char* attribute);
pugi::xml_node array_named(pugi::xml_node parent, const char* name);
/// Calls take(cursor, type) `count` times: it reads one number of the array.
Status read_array(const VtkXml& file, pugi::xml_node array, std::size_t count,
                  const std::function<void(MeshCursor&, NumberType)>& take);
Status read_wholes(const VtkXml& file, pugi::xml_node array, std::size_t count,
                   std::vector<std::int64_t>& values);
/// The points of a piece, behind those that are there.
Status read_points(const VtkXml& file, pugi::xml_node piece, std::size_t count, std::vector<Vec3d>& points);
/// The two arrays of `count` cells: where each ends, and the corners of all.
Status read_corners(const VtkXml& file, pugi::xml_node cells, std::size_t count,
                    std::vector<std::int64_t>& ends, std::vector<std::int64_t>& corners);

}  // namespace turgor::io
