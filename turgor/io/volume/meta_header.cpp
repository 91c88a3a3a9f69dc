// Header of a MetaImage file: "Key = Value" lines up to ElementDataFile. Lengths in millimeters, LPS.
#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <map>
#include <span>

#include <fmt/format.h>

#include "turgor/io/files/header_text.hpp"
#include "turgor/io/volume/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

bool meta_type(const std::string& text, SampleType& type) {
  static const std::map<std::string, SampleType, std::less<>> kTypes = {
      {"MET_CHAR", SampleType::kInt8},       {"MET_UCHAR", SampleType::kUint8},
      {"MET_SHORT", SampleType::kInt16},     {"MET_USHORT", SampleType::kUint16},
      {"MET_INT", SampleType::kInt32},       {"MET_UINT", SampleType::kUint32},
      {"MET_LONG_LONG", SampleType::kInt64}, {"MET_ULONG_LONG", SampleType::kUint64},
      {"MET_FLOAT", SampleType::kFloat},     {"MET_DOUBLE", SampleType::kDouble}};
  const auto found = kTypes.find(text);
  if (found == kTypes.end()) return false;
  type = found->second;
  return true;
}

bool is_true(const std::string& text) {
  return text.starts_with('T') || text.starts_with('t') || text == "1";
}

/// Reads the numbers of these synonymous keys, if one exists; duplicate keys must agree.
Status read_numbers(const fs::path& path, const TextFields& fields, std::initializer_list<const char*> keys,
                    std::span<double> numbers) {
  std::string first;
  for (const std::string key : keys) {
    if (!fields.has(key)) continue;
    const std::vector<double> found = real_numbers(fields.get(key));
    if (found.size() != numbers.size())
      return Error{fmt::format("{}: \"{} = {}\"; expected {} finite numbers", path.string(), key,
                               fields.get(key), numbers.size())};
    if (!first.empty() && !std::equal(found.begin(), found.end(), numbers.begin()))
      return Error{fmt::format("{}: \"{} = {}\" contradicts \"{} = {}\"", path.string(), key, fields.get(key),
                               first, fields.get(first))};
    std::copy(found.begin(), found.end(), numbers.begin());
    first = key;
  }
  return Done{};
}

Status read_grid(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  std::array<double, 3> spacing{1, 1, 1}, origin{};
  if (!fields.has("ElementSpacing") && !fields.has("ElementSize")) header.missing = "spacing";
  std::array<double, 9> rows{1, 0, 0, 0, 1, 0, 0, 0, 1};  // one row per axis
  const char* spacing_key = fields.has("ElementSpacing") ? "ElementSpacing" : "ElementSize";
  if (Status read = read_numbers(path, fields, {spacing_key}, spacing); !read) return read;
  if (Status read = read_numbers(path, fields, {"Offset", "Position", "Origin"}, origin); !read) return read;
  if (Status read = read_numbers(path, fields, {"TransformMatrix", "Rotation", "Orientation"}, rows); !read)
    return read;
  if (const std::string unit = fields.get("DistanceUnits");
      fields.has("DistanceUnits") && !is_millimeter(unit))
    return Error{fmt::format("{}: DistanceUnits = {}; expected mm", path.string(), unit)};
  for (int axis = 0; axis < 3; axis++) {
    const double* row = rows.data() + 3 * axis;
    const Vec3d direction{row[0], row[1], row[2]};
    if (!(std::abs(norm(direction) - 1) < 1e-3))
      return Error{fmt::format("{}: the direction of axis {} ({} {} {}) has length {}; expected 1",
                               path.string(), axis, row[0], row[1], row[2], norm(direction))};
    header.grid.axes.column[axis] = normalized(direction);
    header.grid.spacing[axis] = spacing[std::size_t(axis)] * 1e-3;
    header.grid.origin[axis] = origin[std::size_t(axis)] * 1e-3;
  }
  return Done{};
}

Status read_scale(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  if (Status read = read_numbers(path, fields, {"ElementToIntensityFunctionSlope"}, {&header.slope, 1});
      !read)
    return read;
  if (header.slope == 0)
    return Error{
        fmt::format("{}: ElementToIntensityFunctionSlope = 0 makes all samples alike", path.string())};
  return read_numbers(path, fields, {"ElementToIntensityFunctionOffset"}, {&header.intercept, 1});
}

Status read_meta_sizes(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::vector<std::int64_t> sizes = whole_numbers(fields.get("DimSize"));
  if (fields.get("NDims") != "3" || sizes.size() != 3)
    return Error{fmt::format("{}: NDims = {}, DimSize = {}; expected one volume (3 dimensions)",
                             path.string(), fields.get("NDims"), fields.get("DimSize"))};
  for (std::size_t axis = 0; axis < 3; axis++) header.size[axis] = sizes[axis];
  if (!fields.has("ElementNumberOfChannels")) return Done{};
  const std::vector<std::int64_t> channels = whole_numbers(fields.get("ElementNumberOfChannels"));
  if (channels.size() != 1 || channels[0] < 1 || channels[0] > kMostComponents)
    return Error{fmt::format("{}: ElementNumberOfChannels = {}", path.string(),
                             fields.get("ElementNumberOfChannels"))};
  header.components = int(channels[0]);
  return Done{};
}

/// Byte order, which has two key names; little-endian if neither is given.
bool is_big_endian(const TextFields& fields) {
  return is_true(
      fields.get(fields.has("BinaryDataByteOrderMSB") ? "BinaryDataByteOrderMSB" : "ElementByteOrderMSB"));
}

/// HeaderSize: bytes before the samples; -1: the samples are the last bytes of the file.
Status read_header_size(const fs::path& path, const TextFields& fields, bool is_local, VolumeHeader& header) {
  if (!fields.has("HeaderSize")) return Done{};
  const std::vector<std::int64_t> size = whole_numbers(fields.get("HeaderSize"));
  header.is_at_end = size.size() == 1 && size[0] == -1 && !header.is_packed;
  const bool is_known = size.size() == 1 && size[0] >= 0 && size[0] <= (is_local ? 0 : kMostSkipped);
  if (!is_known && !header.is_at_end)
    return Error{
        fmt::format("{}: HeaderSize = {} is not read; expected 0, or the bytes before the samples "
                    "in a file of their own, or -1 before raw samples",
                    path.string(), fields.get("HeaderSize"))};
  if (is_known && !is_local) header.data_offset = size[0];
  return Done{};
}

Status find_meta_data(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::string file = fields.get("ElementDataFile");
  const bool is_local = file == "LOCAL" || file == "Local" || file == "local";
  if (file.empty() || file == "LIST" || file.starts_with("LIST ") || file.find('%') != file.npos)
    return Error{fmt::format("{}: ElementDataFile = {} is not read; expected LOCAL or the name of one file",
                             path.string(), file)};
  if (!is_local) {
    header.data_file = path.parent_path() / file;
    header.data_offset = 0;
  }
  header.is_packed = is_true(fields.get("CompressedData"));
  if (header.is_packed && fields.has("CompressedDataSize")) {
    const std::vector<std::int64_t> size = whole_numbers(fields.get("CompressedDataSize"));
    if (size.size() != 1 || size[0] < 0)
      return Error{fmt::format("{}: CompressedDataSize = {}; expected a number of bytes", path.string(),
                               fields.get("CompressedDataSize"))};
    header.packed_length = size[0];
  }
  return read_header_size(path, fields, is_local, header);
}

}  // namespace

Result<VolumeHeader> parse_meta(const fs::path& path, std::string_view head) {
  std::size_t end = 0;
  const Result<TextFields> read = read_meta_fields(path, head, end);
  if (!read) return read.error();
  const TextFields& fields = *read;
  VolumeHeader header{
      .format = VolumeFormat::kMetaImage, .data_file = path, .data_offset = std::int64_t(end)};
  if (fields.has("ObjectType") && fields.get("ObjectType") != "Image")
    return Error{fmt::format("{}: ObjectType = {}; expected Image", path.string(), fields.get("ObjectType"))};
  if (!meta_type(fields.get("ElementType"), header.type))
    return Error{fmt::format("{}: ElementType = {} is not read; expected whole or real numbers",
                             path.string(), fields.get("ElementType"))};
  if (!is_true(fields.get("BinaryData")))
    return Error{fmt::format("{}: BinaryData = False (text) is not read; expected True", path.string())};
  if (Status sizes = read_meta_sizes(path, fields, header); !sizes) return sizes.error();
  if (Status grid = read_grid(path, fields, header); !grid) return grid.error();
  if (Status scale = read_scale(path, fields, header); !scale) return scale.error();
  header.is_swapped = is_big_endian(fields) != (std::endian::native == std::endian::big);
  if (Status data = find_meta_data(path, fields, header); !data) return data.error();
  return header;
}

}  // namespace turgor::io
