// Header of a NIfTI, NRRD or MetaImage file. Its sizes are checked before memory is allocated, because a
// corrupt header may claim anything. Internal to io/.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/io/volume/organ_names.hpp"

namespace turgor::io {

enum class VolumeFormat { kNifti, kNrrd, kMetaImage };
std::string_view name(VolumeFormat format);

enum class SampleType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };
std::size_t byte_size(SampleType type);

struct VolumeHeader {
  VolumeFormat format{};
  SampleType type{};
  std::array<std::int64_t, 3> size{};  // samples along i, j, k
  int components = 1;
  double slope = 1, intercept = 0;    // value = slope · stored + intercept (NIfTI)
  bool is_swapped = false;            // byte order differs from this machine's
  std::int64_t component_stride = 1;  // samples from one component to the next of the same voxel in the file
  Grid grid{};
  std::string missing;     // what the file does not state of its grid, such as "spacing"; empty: nothing
  LabelNames label_names;  // of a segmentation, if the file has them

  // Location of the samples in the data file: `data_offset` bytes, then `skipped_lines`, then the samples or
  // a compressed stream. The first `skipped_bytes` of the decompressed data are skipped.
  std::filesystem::path data_file;  // this file, or the one that it names
  std::int64_t data_offset = 0, skipped_lines = 0, skipped_bytes = 0;
  bool is_packed = false;
  std::int64_t packed_length = 0;  // of the compressed stream; 0 = to the end of the file [bytes]
  bool is_at_end = false;          // raw samples are the last bytes of the file
};

/// Label names of a NIfTI extension: XML with <Label Key="5">liver</Label>, or pairs of a number and a name
/// in either order, as in {"5": "liver"}. Empty if it has none.
LabelNames label_names_in(std::string_view text);

/// Label names of a file from its header; empty if it cannot be read.
LabelNames read_header_names(const std::filesystem::path& path);
/// Reads and checks the header of a file, whose format is recognized by content.
Result<VolumeHeader> read_volume_header(const std::filesystem::path& path);

// The three formats. `head` holds the first bytes of the file, decompressed if the whole file is compressed.
Result<VolumeHeader> parse_nifti(const std::filesystem::path& path, std::string_view head);
Result<VolumeHeader> parse_nrrd(const std::filesystem::path& path, std::string_view head);
Result<VolumeHeader> parse_meta(const std::filesystem::path& path, std::string_view head);

/// Largest number of bytes or lines before the samples.
constexpr std::int64_t kMostSkipped = std::int64_t{1} << 40;
constexpr std::int64_t kMostComponents = 100;
/// Largest volume that is read: 2^33 samples.
constexpr std::int64_t kMaxSamples = std::int64_t{1} << 33;
/// Checks sizes (positive, small enough together) and components.
Status check_extent(const std::filesystem::path& path, const VolumeHeader& header);

}  // namespace turgor::io
