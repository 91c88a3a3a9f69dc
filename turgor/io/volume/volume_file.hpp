// NIfTI, NRRD and MetaImage files as bytes of one sample type. Internal to io/.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/volume/volume_header.hpp"

namespace turgor::io {

struct RawVolume {
  VolumeFormat format{};
  Grid grid;
  SampleType type{};
  int components = 1;
  double slope = 1, intercept = 0;  // value = slope · stored + intercept
  std::vector<std::byte> bytes;     // components fastest, then i
  LabelNames label_names;           // of a segmentation, if the file has them
  std::string missing;              // as in VolumeHeader

  std::size_t value_count() const { return bytes.size() / byte_size(type); }
};

Result<RawVolume> read_volume_file(const std::filesystem::path& path);

struct SamplesToWrite {
  const Grid& grid;
  SampleType type;
  int components;
  const void* data;

  /// All samples, components fastest.
  std::string_view bytes() const {
    const std::size_t count = sample_count(grid) * std::size_t(components) * byte_size(type);
    return {static_cast<const char*>(data), count};
  }
};
/// Writes the format that the name says.
Status write_volume_file(const std::filesystem::path& path, const SamplesToWrite& samples,
                         const Exec& exec = Exec(1));

/// Samples of a file with a known header, in this machine's byte order. The file must hold all samples of the
/// header, and a compressed stream no more than these.
Result<RawVolume> read_volume_samples(const std::filesystem::path& path, const VolumeHeader& header);
/// Slices [begin, end) alone. Further error: a compressed file.
Result<RawVolume> read_volume_slices(const std::filesystem::path& path, const VolumeHeader& header, int begin,
                                     int end);
/// Checks that the spacing is positive, the axes are orthogonal, and all corners are within 1e9 m of the
/// frame's origin.
Status check_grid(const std::filesystem::path& path, const Grid& grid);

// The three formats, into an open file; write_volume_file calls them.
Status write_nifti(FileWriter& file, const std::filesystem::path& path, const SamplesToWrite& samples,
                   const Exec& exec);
void write_nrrd(FileWriter& file, const SamplesToWrite& samples, const Exec& exec);
void write_meta_image(FileWriter& file, const SamplesToWrite& samples);

/// Calls f with a pointer to the samples of the actual type.
template <class F>
auto visit_samples(const RawVolume& raw, F f) {
  const auto* p = raw.bytes.data();
  switch (raw.type) {
    case SampleType::kInt8:
      return f(reinterpret_cast<const std::int8_t*>(p));
    case SampleType::kUint8:
      return f(reinterpret_cast<const std::uint8_t*>(p));
    case SampleType::kInt16:
      return f(reinterpret_cast<const std::int16_t*>(p));
    case SampleType::kUint16:
      return f(reinterpret_cast<const std::uint16_t*>(p));
    case SampleType::kInt32:
      return f(reinterpret_cast<const std::int32_t*>(p));
    case SampleType::kUint32:
      return f(reinterpret_cast<const std::uint32_t*>(p));
    case SampleType::kInt64:
      return f(reinterpret_cast<const std::int64_t*>(p));
    case SampleType::kUint64:
      return f(reinterpret_cast<const std::uint64_t*>(p));
    case SampleType::kFloat:
      return f(reinterpret_cast<const float*>(p));
    default:
      return f(reinterpret_cast<const double*>(p));
  }
}

}  // namespace turgor::io
