#include "turgor/io/mesh/surface_files.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "turgor/io/files/within_memory.hpp"
#include "turgor/io/mesh/mesh_bytes.hpp"
#include "turgor/io/mesh/mesh_frame.hpp"
#include "turgor/io/mesh/surface_formats.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace io {

namespace {

/// The size of a binary STL file follows from the triangle count at byte 80.
bool has_size_of_stl(std::string_view head, std::uintmax_t size) {
  if (head.size() < 84) return false;
  FileCursor cursor("", head);
  cursor.encoding = Encoding::kLittleEndian;
  cursor.seek(80);
  return size == 84 + 50 * std::uintmax_t(cursor.unsigned_whole(4, "a number of triangles"));
}

bool begins_as_obj(std::string_view head) {
  constexpr std::array<std::string_view, 11> kKeywords{"v", "vn", "vt", "vp",     "f",     "l",
                                                       "o", "g",  "s",  "mtllib", "usemtl"};
  FileCursor cursor("", head);
  cursor.has_comments = true;
  return std::find(kKeywords.begin(), kKeywords.end(), cursor.word()) != kKeywords.end();
}

Result<FoundSurface> parse_surface(const fs::path& path, std::string_view bytes) {
  switch (surface_format(path, bytes, bytes.size())) {
    case SurfaceFormat::kObj:
      return parse_obj(path, bytes);
    case SurfaceFormat::kStlText:
      return parse_stl_text(path, bytes);
    case SurfaceFormat::kStlBinary:
      return parse_stl_binary(path, bytes);
    case SurfaceFormat::kPly:
      return parse_ply(path, bytes);
    case SurfaceFormat::kVtp:
      return parse_vtp(path, bytes);
    case SurfaceFormat::kVtk:
      return parse_vtk_surface(path, bytes);
    case SurfaceFormat::kNone:
      break;
  }
  return Error{fmt::format("{}: expected a surface (OBJ, STL, PLY, VTP, VTK), found {}", path.string(),
                           quoted(bytes.substr(0, bytes.find('\n'))))};
}

/// True if the DATASET line of a legacy file says POLYDATA. It follows a title of arbitrary text.
bool is_legacy_polydata(std::string_view head) {
  FileCursor cursor("", head);
  cursor.line(), cursor.line();
  const std::size_t dataset = head.find("\nDATASET", std::max<std::size_t>(cursor.offset(), 1) - 1);
  if (dataset == std::string_view::npos) return false;
  cursor.seek(dataset + 1);
  cursor.word();
  return cursor.word() == "POLYDATA";
}

}  // namespace

SurfaceFormat vtk_surface_format(std::string_view head) {
  if (head.starts_with("# vtk DataFile"))
    return is_legacy_polydata(head) ? SurfaceFormat::kVtk : SurfaceFormat::kNone;
  FileCursor cursor("", head);
  const std::string_view first = cursor.word();
  if (!first.starts_with("<?xml") && !first.starts_with("<VTKFile")) return SurfaceFormat::kNone;
  const std::size_t begin = std::min(head.find("<VTKFile"), head.size());
  const std::string_view tag = head.substr(begin, std::min(head.find('>', begin), head.size()) - begin);
  return tag.find("PolyData") != tag.npos ? SurfaceFormat::kVtp : SurfaceFormat::kNone;
}

SurfaceFormat surface_format(const fs::path& path, std::string_view head, std::uintmax_t size) {
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return SurfaceFormat::kPly;
  if (const SurfaceFormat vtk = vtk_surface_format(head); vtk != SurfaceFormat::kNone) return vtk;
  if (has_size_of_stl(head, size)) return SurfaceFormat::kStlBinary;
  FileCursor cursor(path, head);
  const std::string first = lower_case(cursor.word());
  cursor.line();
  const std::string second = lower_case(cursor.word());
  if (first == "solid" && (second == "facet" || second == "endsolid")) return SurfaceFormat::kStlText;
  if (begins_as_obj(head)) return SurfaceFormat::kObj;
  // Truncated or damaged: only the name shows the format.
  return lower_case(path.extension().string()) == ".stl" ? SurfaceFormat::kStlBinary : SurfaceFormat::kNone;
}

}  // namespace io

Result<ReadSurface> read_surface(const fs::path& path, double scale) {
  TURGOR_ASSERT(scale > 0, "a scale is positive");
  return io::within_memory(path, [&]() -> Result<ReadSurface> {
    const Result<std::string> bytes = io::read_mesh_bytes(path);
    if (!bytes) return bytes.error();
    const Result<io::FoundSurface> found = io::parse_surface(path, *bytes);
    if (!found) return found.error();
    Result<ReadSurface> read = io::finish_surface(path, *found, scale);
    if (read) io::note_frame(*bytes, found->frame, read->notes);
    return read;
  });
}

bool is_surface_file(const fs::path& path) {
  const std::string head = io::first_bytes(path);
  std::error_code failed;
  return !head.empty() &&
         io::surface_format(path, head, fs::file_size(path, failed)) != io::SurfaceFormat::kNone;
}

}  // namespace turgor
