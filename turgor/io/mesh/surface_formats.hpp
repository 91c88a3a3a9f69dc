// Shared by the readers of surfaces: polygons as a file lists them, and the parsers of the formats. Internal
// to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/files/file_cursor.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor::io {

/// A surface as its file lists it.
struct FoundSurface {
  std::string format;
  std::vector<Vec3d> vertices;
  std::vector<std::int64_t> corners;  // of all polygons, from 0
  std::vector<std::size_t> ends;      // end of each polygon in `corners`
  int first = 0;                      // the file's own number of its first vertex
  std::vector<std::string> notes;     // ignored data: sentences
  std::string frame;                  // field kFrameField of a VTK file, such as "RAS"
};

/// Valid surface: welded, triangulated, checked.
Result<ReadSurface> finish_surface(const std::filesystem::path& path, const FoundSurface& found,
                                   double scale);

enum class SurfaceFormat { kNone, kObj, kStlText, kStlBinary, kPly, kVtp, kVtk };
/// `size` is that of the whole file, because binary STL files are recognized only by it.
SurfaceFormat surface_format(const std::filesystem::path& path, std::string_view head, std::uintmax_t size);

/// Format of a VTK surface (PolyData): XML or legacy; kNone for other VTK data.
SurfaceFormat vtk_surface_format(std::string_view head);

Result<FoundSurface> parse_obj(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSurface> parse_stl_text(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSurface> parse_stl_binary(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSurface> parse_ply(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSurface> parse_vtp(const std::filesystem::path& path, std::string_view bytes);
Result<FoundSurface> parse_vtk_surface(const std::filesystem::path& path, std::string_view bytes);

}  // namespace turgor::io
