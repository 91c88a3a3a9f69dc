// Header of an NRRD file: lines of text up to an empty line. It gives type, size and location of the samples;
// nrrd_grid.cpp gives their grid.
#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include <fmt/format.h>

#include "turgor/io/files/file_cursor.hpp"
#include "turgor/io/files/header_text.hpp"
#include "turgor/io/volume/nrrd_grid.hpp"
#include "turgor/io/volume/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

bool nrrd_type(const std::string& text, SampleType& type) {
  static const std::map<std::string, SampleType, std::less<>> kTypes = {
      {"signed char", SampleType::kInt8},
      {"int8", SampleType::kInt8},
      {"int8_t", SampleType::kInt8},
      {"uchar", SampleType::kUint8},
      {"unsigned char", SampleType::kUint8},
      {"uint8", SampleType::kUint8},
      {"uint8_t", SampleType::kUint8},
      {"short", SampleType::kInt16},
      {"short int", SampleType::kInt16},
      {"signed short", SampleType::kInt16},
      {"int16", SampleType::kInt16},
      {"int16_t", SampleType::kInt16},
      {"ushort", SampleType::kUint16},
      {"unsigned short", SampleType::kUint16},
      {"uint16", SampleType::kUint16},
      {"unsigned short int", SampleType::kUint16},
      {"uint16_t", SampleType::kUint16},
      {"int", SampleType::kInt32},
      {"signed int", SampleType::kInt32},
      {"int32", SampleType::kInt32},
      {"int32_t", SampleType::kInt32},
      {"uint", SampleType::kUint32},
      {"unsigned int", SampleType::kUint32},
      {"uint32", SampleType::kUint32},
      {"uint32_t", SampleType::kUint32},
      {"longlong", SampleType::kInt64},
      {"long long", SampleType::kInt64},
      {"long long int", SampleType::kInt64},
      {"signed long long", SampleType::kInt64},
      {"signed long long int", SampleType::kInt64},
      {"int64", SampleType::kInt64},
      {"int64_t", SampleType::kInt64},
      {"ulonglong", SampleType::kUint64},
      {"unsigned long long", SampleType::kUint64},
      {"unsigned long long int", SampleType::kUint64},
      {"uint64", SampleType::kUint64},
      {"uint64_t", SampleType::kUint64},
      {"float", SampleType::kFloat},
      {"double", SampleType::kDouble}};
  const auto found = kTypes.find(text);
  if (found == kTypes.end()) return false;
  type = found->second;
  return true;
}

/// Rejects unknown fields, so that a misspelled field is not silently ignored.
Status check_fields(const fs::path& path, const TextFields& fields) {
  static const std::set<std::string, std::less<>> kKnown = {"type",         "dimension",
                                                            "space",        "space dimension",
                                                            "sizes",        "space directions",
                                                            "kinds",        "endian",
                                                            "encoding",     "space origin",
                                                            "spacings",     "axis mins",
                                                            "axis maxs",    "centerings",
                                                            "thicknesses",  "labels",
                                                            "units",        "space units",
                                                            "old min",      "old max",
                                                            "oldmin",       "oldmax",
                                                            "data file",    "line skip",
                                                            "byte skip",    "number",
                                                            "content",      "block size",
                                                            "blocksize",    "measurement frame",
                                                            "sample units", "sampleunits",
                                                            "min",          "max"};
  for (const auto& [key, value] : fields.values)
    if (!kKnown.contains(key)) return Error{fmt::format("{}: unknown NRRD field \"{}\"", path.string(), key)};
  return Done{};
}

bool is_of_space(std::string_view kind) {
  return kind == "domain" || kind == "space" || kind == "time" || kind == "none" || kind == "???";
}

/// Axis of components among four: the one without a direction in space. -1: none.
int component_axis(const TextFields& fields, const std::vector<std::int64_t>& sizes) {
  const auto directions = nrrd_vectors(fields.get("space directions"));
  const auto none = std::find(directions.begin(), directions.end(), std::nullopt);
  const auto axis = std::size_t(none - directions.begin());
  return sizes.size() == 4 && none != directions.end() && axis < 4 ? int(axis) : -1;
}

Status read_nrrd_sizes(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::vector<std::int64_t> dimension = whole_numbers(fields.get("dimension"));
  std::vector<std::int64_t> sizes = whole_numbers(fields.get("sizes"));
  if (dimension.size() != 1 || std::int64_t(sizes.size()) != dimension[0])
    return Error{fmt::format("{}: corrupt: dimension \"{}\" with sizes \"{}\"", path.string(),
                             fields.get("dimension"), fields.get("sizes"))};
  const int axis = component_axis(fields, sizes);
  if (sizes.size() != (axis < 0 ? 3u : 4u))
    return Error{fmt::format("{}: {} dimensions ({}); expected one volume (3 dimensions)", path.string(),
                             sizes.size(), fields.get("sizes"))};
  if (axis >= 0) {
    const std::int64_t components = sizes[std::size_t(axis)];
    if (components < 1 || components > kMostComponents)
      return Error{
          fmt::format("{}: {} components; expected 1 to {}", path.string(), components, kMostComponents)};
    header.components = int(components);
    for (int before = 0; before < axis; before++)  // check_extent refuses larger sizes later
      header.component_stride *= std::clamp<std::int64_t>(sizes[std::size_t(before)], 0, 65535);
    sizes.erase(sizes.begin() + axis);
  }
  std::copy(sizes.begin(), sizes.end(), header.size.begin());
  return Done{};
}

/// Checks that all axes are spatial, except the axis of components.
Status check_kinds(const fs::path& path, const TextFields& fields) {
  const std::vector<std::int64_t> sizes = whole_numbers(fields.get("sizes"));
  const std::string text = lower_case(fields.get("kinds"));
  std::vector<std::string_view> kinds = words(text);
  if (!fields.has("kinds")) kinds.resize(sizes.size(), "???");
  bool is_known = kinds.size() == sizes.size();
  for (std::size_t axis = 0; is_known && axis < sizes.size(); axis++) {
    if (int(axis) != component_axis(fields, sizes))
      is_known = is_of_space(kinds[axis]);
    else
      is_known = sizes[axis] == 1 || !is_of_space(kinds[axis]);
  }
  if (is_known) return Done{};
  return Error{
      fmt::format("{}: \"kinds: {}\" of {} dimensions; expected \"domain\" for 3 of space, and "
                  "\"vector\" for one without a direction",
                  path.string(), text, sizes.size())};
}

std::string free_text(const TextFields& fields, const std::string& key) {
  const auto found = fields.free.find(key);
  return found == fields.free.end() ? std::string{} : found->second;
}

/// Segments as 3D Slicer writes them. Overlapping segments are in several layers: components of the image.
Status read_segments(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  constexpr int kMost = 65536;
  for (int segment = 0; segment < kMost; segment++) {
    const std::string key = fmt::format("Segment{}_", segment);
    const std::string name = free_text(fields, key + "Name"), layer = free_text(fields, key + "Layer"),
                      value = free_text(fields, key + "LabelValue");
    if (name.empty() && value.empty() && free_text(fields, key + "ID").empty()) break;
    if (header.components > 1 || (!layer.empty() && layer != "0"))
      return Error{fmt::format(
          "{}: a segmentation of several layers ({}), in which segments overlap, is not supported; "
          "expected one layer: export it as a label map, or remove the overlaps",
          path.string(), header.components)};
    const std::vector<std::int64_t> label =
        value.empty() ? std::vector<std::int64_t>{segment + 1} : whole_numbers(value);
    if (label.size() == 1 && label[0] > 0 && label[0] <= 65535 && !name.empty())
      header.label_names.emplace(int(label[0]), name);
  }
  return Done{};
}

/// Bytes or lines before the samples; 0 if the field is missing.
Result<std::int64_t> read_skip(const fs::path& path, const TextFields& fields, const char* key,
                               std::int64_t least) {
  if (!fields.has(key)) return std::int64_t{0};
  const std::vector<std::int64_t> skip = whole_numbers(fields.get(key));
  if (skip.size() == 1 && skip[0] >= least && skip[0] <= kMostSkipped) return skip[0];
  return Error{
      fmt::format("{}: \"{}: {}\"; expected {} or more", path.string(), key, fields.get(key), least)};
}

Status read_encoding(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::string encoding = lower_case(fields.get("encoding")), endian = lower_case(fields.get("endian"));
  header.is_packed = encoding == "gzip" || encoding == "gz";
  if (!header.is_packed && encoding != "raw")
    return Error{
        fmt::format("{}: NRRD encoding \"{}\" is not read; expected raw or gzip", path.string(), encoding)};
  if (byte_size(header.type) > 1 && endian != "little" && endian != "big")
    return Error{fmt::format("{}: \"endian: {}\"; expected little or big", path.string(), endian)};
  header.is_swapped = (endian == "big") != (std::endian::native == std::endian::big);
  const Result<std::int64_t> lines = read_skip(path, fields, "line skip", 0);
  if (!lines) return lines.error();
  const Result<std::int64_t> bytes = read_skip(path, fields, "byte skip", header.is_packed ? 0 : -1);
  if (!bytes) return bytes.error();
  header.skipped_lines = *lines;
  header.is_at_end = *bytes < 0;
  header.skipped_bytes = std::max<std::int64_t>(*bytes, 0);
  return Done{};
}

Status find_nrrd_data(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  if (!fields.has("data file")) return Done{};
  const std::string file = fields.get("data file");
  if (file.empty() || file.find('%') != file.npos || file.starts_with("LIST"))
    return Error{fmt::format("{}: NRRD data file \"{}\" is not read; expected the name of one file",
                             path.string(), file)};
  header.data_file = path.parent_path() / file;
  header.data_offset = 0;
  return Done{};
}

}  // namespace

Result<VolumeHeader> parse_nrrd(const fs::path& path, std::string_view head) {
  std::size_t end = 0;
  const Result<TextFields> read = read_nrrd_fields(path, head, end);
  if (!read) return read.error();
  const TextFields& fields = *read;
  VolumeHeader header{.format = VolumeFormat::kNrrd, .data_file = path, .data_offset = std::int64_t(end)};
  if (Status known = check_fields(path, fields); !known) return known.error();
  if (!nrrd_type(lower_case(fields.get("type")), header.type))
    return Error{fmt::format("{}: NRRD sample type \"{}\" is not read; expected whole or real numbers",
                             path.string(), fields.get("type"))};
  if (Status sizes = read_nrrd_sizes(path, fields, header); !sizes) return sizes.error();
  if (Status segments = read_segments(path, fields, header); !segments) return segments.error();
  if (Status kinds = check_kinds(path, fields); !kinds) return kinds.error();
  if (Status grid = read_nrrd_grid(path, fields, header.grid); !grid) return grid.error();
  if (!fields.has("space directions") && !fields.has("spacings")) header.missing = "spacing";
  if (Status encoding = read_encoding(path, fields, header); !encoding) return encoding.error();
  if (Status data = find_nrrd_data(path, fields, header); !data) return data.error();
  return header;
}

}  // namespace turgor::io
