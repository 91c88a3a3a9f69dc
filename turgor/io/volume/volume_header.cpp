// Recognizes the format by content and checks the sizes of a header for plausibility.
#include "turgor/io/volume/volume_header.hpp"

#include <memory>

#include <fmt/format.h>
#include <zlib.h>

#include "turgor/io/files/input_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestHeader = std::size_t{1} << 18;

struct CloseGzip {
  void operator()(gzFile_s* file) const { gzclose(file); }
};
using GzipFile = std::unique_ptr<gzFile_s, CloseGzip>;

bool starts_with_gzip_magic(const fs::path& path) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  return file && std::fgetc(file.get()) == 0x1f && std::fgetc(file.get()) == 0x8b;
}

/// First bytes of a file, decompressed if the whole file is a gzip stream.
std::string read_head(const fs::path& path, std::size_t count) {
  const GzipFile file(gzopen(path.c_str(), "rb"));
  std::string head(count, '\0');
  const int got = file ? gzread(file.get(), head.data(), static_cast<unsigned>(count)) : 0;
  head.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return head;
}

bool looks_like_nifti(std::string_view head) {
  if (head.size() < 348) return false;
  const std::string_view start = head.substr(0, 4), magic = head.substr(344, 3);
  using namespace std::string_view_literals;
  return start == "\x5c\x01\0\0"sv || start == "\0\0\x01\x5c"sv || start == "\x1c\x02\0\0"sv ||
         start == "\0\0\x02\x1c"sv || magic == "n+1" || magic == "ni1";
}

bool looks_like_meta(std::string_view head) {
  const std::string_view start = head.substr(0, 2048);
  return start.find("NDims") != start.npos && start.find('=') != start.npos &&
         start.find('\0') > start.find("NDims");
}

Result<VolumeHeader> parse(const fs::path& path, std::string_view head) {
  if (head.starts_with("NRRD")) return parse_nrrd(path, head);
  if (looks_like_nifti(head)) return parse_nifti(path, head);
  if (looks_like_meta(head)) return parse_meta(path, head);
  return Error{fmt::format(
      "{}: not a volume that can be read; expected DICOM, NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr) or "
      "MetaImage (.mha, .mhd)",
      path.string())};
}

}  // namespace

std::string_view name(VolumeFormat format) {
  return format == VolumeFormat::kNifti ? "NIfTI" : format == VolumeFormat::kNrrd ? "NRRD" : "MetaImage";
}

std::size_t byte_size(SampleType type) {
  switch (type) {
    case SampleType::kInt8:
    case SampleType::kUint8:
      return 1;
    case SampleType::kInt16:
    case SampleType::kUint16:
      return 2;
    case SampleType::kInt32:
    case SampleType::kUint32:
    case SampleType::kFloat:
      return 4;
    default:
      return 8;
  }
}

Status check_extent(const fs::path& path, const VolumeHeader& header) {
  std::int64_t samples = header.components;
  for (const std::int64_t size : header.size) {
    if (size < 1 || size > 65535)
      return Error{fmt::format("{}: a size of {} x {} x {} samples; expected 1 to 65535 each", path.string(),
                               header.size[0], header.size[1], header.size[2])};
    samples *= size;
    if (samples > kMaxSamples)
      return Error{fmt::format(
          "{}: {} x {} x {} samples of {} components are more than the largest volume of 2^33 samples",
          path.string(), header.size[0], header.size[1], header.size[2], header.components)};
  }
  return Done{};
}

LabelNames read_header_names(const fs::path& path) {
  if (!check_input(path)) return {};
  const Result<VolumeHeader> header = parse(path, read_head(path, kLongestHeader));
  return header ? header->label_names : LabelNames{};
}

Result<VolumeHeader> read_volume_header(const fs::path& path) {
  Result<VolumeHeader> header = parse(path, read_head(path, kLongestHeader));
  if (!header) return header;
  if (starts_with_gzip_magic(path)) {
    if (header->format != VolumeFormat::kNifti || path.extension() != ".gz")
      return Error{fmt::format(
          "{}: a gzip file with {} inside; expected such a file to be NIfTI and to be named .nii.gz",
          path.string(), name(header->format))};
    header->is_packed = true;
    header->skipped_bytes = std::exchange(header->data_offset, 0);
  }
  if (Status extent = check_extent(path, *header); !extent) return extent.error();
  header->grid.size = {int(header->size[0]), int(header->size[1]), int(header->size[2])};
  return header;
}

}  // namespace turgor::io
