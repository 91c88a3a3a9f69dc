// The header of an NRRD file: lines of text up to an empty one. Only what decides how many samples there are
// and where is read here; ITK places the volume.
#include <charconv>
#include <map>

#include <fmt/format.h>

#include "turgor/io/header_text.hpp"
#include "turgor/io/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

bool sample_type(const std::string& text, SampleType& type) {
  static const std::map<std::string, SampleType, std::less<>> kTypes = {
      {"signed char", SampleType::kInt8},    {"int8", SampleType::kInt8},
      {"int8_t", SampleType::kInt8},         {"uchar", SampleType::kUint8},
      {"unsigned char", SampleType::kUint8}, {"uint8", SampleType::kUint8},
      {"uint8_t", SampleType::kUint8},       {"short", SampleType::kInt16},
      {"short int", SampleType::kInt16},     {"signed short", SampleType::kInt16},
      {"int16", SampleType::kInt16},         {"int16_t", SampleType::kInt16},
      {"ushort", SampleType::kUint16},       {"unsigned short", SampleType::kUint16},
      {"uint16", SampleType::kUint16},       {"unsigned short int", SampleType::kUint16},
      {"uint16_t", SampleType::kUint16},     {"int", SampleType::kInt32},
      {"signed int", SampleType::kInt32},    {"int32", SampleType::kInt32},
      {"int32_t", SampleType::kInt32},       {"uint", SampleType::kUint32},
      {"unsigned int", SampleType::kUint32}, {"uint32", SampleType::kUint32},
      {"uint32_t", SampleType::kUint32},     {"float", SampleType::kFloat},
      {"double", SampleType::kDouble}};
  const auto found = kTypes.find(text);
  if (found == kTypes.end()) return false;
  type = found->second;
  return true;
}

// Exactly one axis of a four-dimensional file holds components: the one without a direction in space
// ("none").
int component_axis(const std::string& directions) {
  int axis = 0;
  for (std::size_t at = 0; at < directions.size();) {
    if (directions.compare(at, 4, "none") == 0) return axis;
    if (directions[at] == '(') {
      at = directions.find(')', at);
      if (at == directions.npos) return -1;
      axis++;
    }
    at++;
  }
  return -1;
}

Status read_sizes(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::vector<std::int64_t> dimension = whole_numbers(fields.get("dimension"));
  std::vector<std::int64_t> sizes = whole_numbers(fields.get("sizes"));
  if (dimension.size() != 1 || std::int64_t(sizes.size()) != dimension[0])
    return Error{fmt::format("{}: corrupt: dimension \"{}\" with sizes \"{}\"", path.string(),
                             fields.get("dimension"), fields.get("sizes"))};
  if (sizes.size() == 4) {
    const int axis = component_axis(fields.get("space directions"));
    if (axis < 0 || sizes[std::size_t(axis)] < 1 || sizes[std::size_t(axis)] > 100)
      return Error{fmt::format("{}: 4 dimensions ({}); expected one volume (3 dimensions)", path.string(),
                               fields.get("sizes"))};
    header.components = int(sizes[std::size_t(axis)]);
    sizes.erase(sizes.begin() + axis);
  }
  if (sizes.size() != 3)
    return Error{fmt::format("{}: {} dimensions; expected 3", path.string(), sizes.size())};
  for (std::size_t axis = 0; axis < 3; axis++) header.size[axis] = sizes[axis];
  return Done{};
}

std::string free_text(const TextFields& fields, const std::string& key) {
  const auto found = fields.free.find(key);
  return found == fields.free.end() ? std::string{} : found->second;
}

/// Segments as 3D Slicer writes them. Those that overlap lie in several layers: components of the image.
Status read_segments(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  constexpr int kMost = 65536;
  for (int segment = 0; segment < kMost; segment++) {
    const std::string key = fmt::format("Segment{}_", segment);
    const std::string name = free_text(fields, key + "Name"), layer = free_text(fields, key + "Layer"),
                      value = free_text(fields, key + "LabelValue");
    if (name.empty() && value.empty() && free_text(fields, key + "ID").empty()) break;
    if (header.components > 1 || (!layer.empty() && layer != "0"))
      return Error{
          fmt::format("{}: a segmentation of several layers ({}), in which segments overlap, is not read; "
                      "expected one layer: "
                      "export it as a label map, or let its segments not overlap",
                      path.string(), header.components)};
    const std::vector<std::int64_t> label =
        value.empty() ? std::vector<std::int64_t>{segment + 1} : whole_numbers(value);
    if (label.size() == 1 && label[0] > 0 && label[0] <= 65535 && !name.empty())
      header.label_names.emplace(int(label[0]), name);
  }
  return Done{};
}

Status check_numbers(const fs::path& path, const TextFields& fields) {
  for (const char* key : {"spacings", "space directions", "space origin"})
    if (fields.has(key) && !all_finite(fields.get(key)))
      return Error{
          fmt::format("{}: \"{}: {}\"; expected finite numbers", path.string(), key, fields.get(key))};
  return Done{};
}

}  // namespace

Result<VolumeHeader> parse_nrrd(const fs::path& path, std::string_view head) {
  std::size_t end = 0;
  const Result<TextFields> read = read_nrrd_fields(path, head, end);
  if (!read) return read.error();
  const TextFields& fields = *read;
  VolumeHeader header{.format = VolumeFormat::kNrrd, .data_file = path, .data_offset = std::int64_t(end)};
  if (!sample_type(fields.get("type"), header.type))
    return Error{fmt::format("{}: NRRD sample type \"{}\" is not read; expected whole or real numbers",
                             path.string(), fields.get("type"))};
  if (Status sizes = read_sizes(path, fields, header); !sizes) return sizes.error();
  if (Status segments = read_segments(path, fields, header); !segments) return segments.error();
  if (Status numbers = check_numbers(path, fields); !numbers) return numbers.error();
  const std::string encoding = fields.get("encoding");
  if (encoding == "gzip" || encoding == "gz")
    header.packing = VolumeHeader::Packing::kGzip;
  else if (encoding != "raw")
    return Error{
        fmt::format("{}: NRRD encoding \"{}\" is not read; expected raw or gzip", path.string(), encoding)};
  for (const char* skip : {"byte skip", "line skip"})
    if (fields.has(skip) && fields.get(skip) != "0")
      return Error{
          fmt::format("{}: NRRD field \"{}: {}\" is not read", path.string(), skip, fields.get(skip))};
  if (fields.has("data file")) {
    const std::string file = fields.get("data file");
    if (file.empty() || file.find(' ') != file.npos || file.find('%') != file.npos ||
        file.starts_with("LIST"))
      return Error{fmt::format("{}: NRRD data file \"{}\" is not read; expected the name of one file",
                               path.string(), file)};
    header.data_file = path.parent_path() / file;
    header.data_offset = 0;
  }
  return header;
}

}  // namespace turgor::io
