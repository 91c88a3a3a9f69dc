// Shared by VTK's XML formats (.vtu, .vtp): the file parsed by pugixml, and its arrays as text, base64 or raw
// bytes. Raw appended bytes are cut before parsing because they are not XML. Internal to io/.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "turgor/core/vec.hpp"
#include "turgor/io/files/file_cursor.hpp"

namespace turgor::io {

struct VtkXml {
  const std::filesystem::path& path;
  std::string_view bytes;
  std::string_view appended;  // after its "_"
  bool is_appended_base64 = false;
  pugi::xml_document xml;
};

/// Parses the file's bytes. Error: invalid XML, a different type (such as "PolyData"), an unknown
/// compression.
Status parse_vtk_xml(VtkXml& file, std::string_view type);
/// "VTU", "VTU (compressed)".
std::string vtk_xml_format(const VtkXml& file, std::string_view name);
/// Frame that the field kFrameField of the data set declares, such as "RAS"; empty without one.
std::string vtk_xml_frame(const VtkXml& file);
Error error_at(const VtkXml& file, pugi::xml_node node, std::string_view message);

/// Number of points or cells of a piece, limited to what the file can hold even when compressed.
Result<std::size_t> read_size(const VtkXml& file, pugi::xml_node piece, const char* attribute);
pugi::xml_node array_named(pugi::xml_node parent, const char* name);
/// Calls take(cursor, type) `count` times; each call reads one number of the array.
Status read_array(const VtkXml& file, pugi::xml_node array, std::size_t count,
                  const std::function<void(FileCursor&, NumberType)>& take);
Status read_wholes(const VtkXml& file, pugi::xml_node array, std::size_t count,
                   std::vector<std::int64_t>& values);
/// Appends the points of a piece.
Status read_points(const VtkXml& file, pugi::xml_node piece, std::size_t count, std::vector<Vec3d>& points);
/// Reads the two arrays of `count` cells: the end of each, and the corners of all.
Status read_corners(const VtkXml& file, pugi::xml_node cells, std::size_t count,
                    std::vector<std::int64_t>& ends, std::vector<std::int64_t>& corners);

}  // namespace turgor::io
