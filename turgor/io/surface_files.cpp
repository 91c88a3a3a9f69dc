#include "turgor/io/surface_files.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "turgor/io/surface_formats.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace io {

namespace {

/// The size of a binary STL file follows from the number at its byte 80.
bool has_size_of_stl(std::string_view head, std::uintmax_t size) {
  if (head.size() < 84) return false;
  MeshCursor cursor("", head);
  cursor.encoding = Encoding::kLittleEndian;
  cursor.seek(80);
  return size == 84 + 50 * std::uintmax_t(cursor.unsigned_whole(4, "a number of triangles"));
}

bool begins_as_obj(std::string_view head) {
  constexpr std::array<std::string_view, 11> kKeywords{"v", "vn", "vt", "vp",     "f",     "l",
                                                       "o", "g",  "s",  "mtllib", "usemtl"};
  MeshCursor cursor("", head);
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
    case SurfaceFormat::kNone:
      break;
  }
  return Error{fmt::format("{}: expected a surface (OBJ, STL, PLY), found {}", path.string(),
                           quoted(bytes.substr(0, bytes.find('\n'))))};
}

}  // namespace

SurfaceFormat surface_format(const fs::path& path, std::string_view head, std::uintmax_t size) {
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return SurfaceFormat::kPly;
  if (has_size_of_stl(head, size)) return SurfaceFormat::kStlBinary;
  MeshCursor cursor(path, head);
  const std::string first = lower_case(cursor.word());
  cursor.line();
  const std::string second = lower_case(cursor.word());
  if (first == "solid" && (second == "facet" || second == "endsolid")) return SurfaceFormat::kStlText;
  if (begins_as_obj(head)) return SurfaceFormat::kObj;
  // Cut off or damaged: the name alone tells what it was.
  return lower_case(path.extension().string()) == ".stl" ? SurfaceFormat::kStlBinary : SurfaceFormat::kNone;
}

}  // namespace io

Result<ReadSurface> read_surface(const fs::path& path, double scale) {
  TURGOR_ASSERT(scale > 0, "a scale is positive");
  const Result<std::string> bytes = io::read_mesh_bytes(path);
  if (!bytes) return bytes.error();
  const Result<io::FoundSurface> found = io::parse_surface(path, *bytes);
  if (!found) return found.error();
  return io::finish_surface(path, *found, scale);
}

bool is_surface_file(const fs::path& path) {
  const std::string head = io::first_bytes(path);
  std::error_code failed;
  return !head.empty() &&
         io::surface_format(path, head, fs::file_size(path, failed)) != io::SurfaceFormat::kNone;
}

}  // namespace turgor
