// NIfTI, NRRD and MetaImage files in and out, as bytes of one sample type. Internal to io/.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

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
  LabelNames label_names;           // of a segmentation, if the file says

  std::size_t value_count() const { return bytes.size() / byte_size(type); }
};

Result<RawVolume> read_volume_file(const std::filesystem::path& path);

struct SamplesToWrite {
  const Grid& grid;
  SampleType type;
  int components;
  const void* data;

  /// All of them, components fastest.
  std::string_view bytes() const {
    const std::size_t count = sample_count(grid) * std::size_t(components) * byte_size(type);
    return {static_cast<const char*>(data), count};
  }
};
/// The format follows from the name.
Status write_volume_file(const std::filesystem::path& path, const SamplesToWrite& samples);

/// The samples of a file whose header is known, in this machine's byte order; all that it promises must be
/// there, and a compressed stream must hold no more.
Result<RawVolume> read_volume_samples(const std::filesystem::path& path, const VolumeHeader& header);
/// Slices [begin, end) of them alone. Error: besides those, a compressed file.
Result<RawVolume> read_volume_slices(const std::filesystem::path& path, const VolumeHeader& header, int begin,
                                     int end);
/// Are the axes and spacings those of a grid of right angles?
Status check_grid(const std::filesystem::path& path, const Grid& grid);

// The three formats, into a file that is open; write_volume_file calls them.
Status write_nifti(FileWriter& file, const std::filesystem::path& path, const SamplesToWrite& samples);
void write_nrrd(FileWriter& file, const SamplesToWrite& samples);
void write_meta_image(FileWriter& file, const SamplesToWrite& samples);

/// Calls f with a pointer to the samples in their own type.
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
