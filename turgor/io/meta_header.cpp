// The header of a MetaImage file: "Key = Value" lines up to ElementDataFile. Only what decides how many
// samples there are and where is read here; ITK places the volume.
#include <map>

#include <fmt/format.h>

#include "turgor/io/header_text.hpp"
#include "turgor/io/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

bool sample_type(const std::string& text, SampleType& type) {
  static const std::map<std::string, SampleType, std::less<>> kTypes = {
      {"MET_CHAR", SampleType::kInt8},   {"MET_UCHAR", SampleType::kUint8},
      {"MET_SHORT", SampleType::kInt16}, {"MET_USHORT", SampleType::kUint16},
      {"MET_INT", SampleType::kInt32},   {"MET_UINT", SampleType::kUint32},
      {"MET_FLOAT", SampleType::kFloat}, {"MET_DOUBLE", SampleType::kDouble}};
  const auto found = kTypes.find(text);
  if (found == kTypes.end()) return false;
  type = found->second;
  return true;
}

bool is_true(const std::string& text) {
  return text.starts_with('T') || text.starts_with('t') || text == "1";
}

Status check_numbers(const fs::path& path, const TextFields& fields) {
  const std::map<std::string, std::size_t> counts = {
      {"ElementSpacing", 3},  {"ElementSize", 3}, {"Offset", 3},      {"Position", 3},        {"Origin", 3},
      {"TransformMatrix", 9}, {"Rotation", 9},    {"Orientation", 9}, {"CenterOfRotation", 3}};
  for (const auto& [key, count] : counts)
    if (fields.has(key) && (!all_finite(fields.get(key)) || word_count(fields.get(key)) != count))
      return Error{fmt::format("{}: \"{} = {}\"; expected {} finite numbers", path.string(), key,
                               fields.get(key), count)};
  return Done{};
}

Status read_sizes(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::vector<std::int64_t> sizes = whole_numbers(fields.get("DimSize"));
  if (fields.get("NDims") != "3" || sizes.size() != 3)
    return Error{fmt::format("{}: NDims = {}, DimSize = {}; expected one volume (3 dimensions)",
                             path.string(), fields.get("NDims"), fields.get("DimSize"))};
  for (std::size_t axis = 0; axis < 3; axis++) header.size[axis] = sizes[axis];
  if (!fields.has("ElementNumberOfChannels")) return Done{};
  const std::vector<std::int64_t> channels = whole_numbers(fields.get("ElementNumberOfChannels"));
  if (channels.size() != 1 || channels[0] < 1 || channels[0] > 100)
    return Error{fmt::format("{}: ElementNumberOfChannels = {}", path.string(),
                             fields.get("ElementNumberOfChannels"))};
  header.components = int(channels[0]);
  return Done{};
}

Status find_data(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  const std::string file = fields.get("ElementDataFile");
  if (fields.has("HeaderSize") && fields.get("HeaderSize") != "0")
    return Error{
        fmt::format("{}: HeaderSize = {} is not read; expected 0", path.string(), fields.get("HeaderSize"))};
  if (is_true(fields.get("CompressedData"))) header.packing = VolumeHeader::Packing::kZlib;
  if (file == "LOCAL" || file == "Local" || file == "local") return Done{};
  if (file.empty() || file == "LIST" || file.starts_with("LIST ") || file.find('%') != file.npos)
    return Error{fmt::format("{}: ElementDataFile = {} is not read; expected LOCAL or the name of one file",
                             path.string(), file)};
  header.data_file = path.parent_path() / file;
  header.data_offset = 0;
  return Done{};
}

// MetaIO allocates this much before it looks at the file.
Status check_compressed_size(const fs::path& path, const TextFields& fields, VolumeHeader& header) {
  if (header.packing != VolumeHeader::Packing::kZlib) return Done{};
  const std::vector<std::int64_t> size = whole_numbers(fields.get("CompressedDataSize"));
  std::error_code failed;
  const auto on_disk = static_cast<std::int64_t>(fs::file_size(header.data_file, failed));
  if (size.size() == 1) header.packed_length = size[0];
  if (!failed && header.packed_length > 0 && header.packed_length <= on_disk - header.data_offset)
    return Done{};
  return Error{fmt::format("{}: truncated or corrupt: CompressedDataSize = {}, {} bytes are there",
                           path.string(), fields.get("CompressedDataSize"),
                           failed ? 0 : on_disk - header.data_offset)};
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
  if (!sample_type(fields.get("ElementType"), header.type))
    return Error{fmt::format("{}: ElementType = {} is not read; expected whole or real numbers",
                             path.string(), fields.get("ElementType"))};
  if (!is_true(fields.get("BinaryData")))
    return Error{fmt::format("{}: BinaryData = False (text) is not read; expected True", path.string())};
  if (Status sizes = read_sizes(path, fields, header); !sizes) return sizes.error();
  if (Status numbers = check_numbers(path, fields); !numbers) return numbers.error();
  if (Status data = find_data(path, fields, header); !data) return data.error();
  if (Status size = check_compressed_size(path, fields, header); !size) return size.error();
  return header;
}

}  // namespace turgor::io
