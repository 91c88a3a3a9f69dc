// NRRD and MetaImage files in and out through ITK, NIfTI by itself, as bytes of one sample type. Internal to
// io/.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/io/volume_header.hpp"

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
};
/// The format follows from the name. Written beside and renamed.
Status write_volume_file(const std::filesystem::path& path, const SamplesToWrite& samples);

/// The samples of a NIfTI file whose header is known. (ITK's reader turns samples that are no number into 0
/// HU: water.)
Result<RawVolume> read_nifti_samples(const std::filesystem::path& path, const VolumeHeader& header);

/// A NIfTI file, straight under this name; write_volume_file calls it.
Status write_nifti(const std::filesystem::path& path, const SamplesToWrite& samples);

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
