// Enhanced images: many frames in one file, each with its position in sequences. [DICOM PS3.3, A.38,
// C.7.6.16]
#include <algorithm>
#include <cmath>

#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

namespace {

/// Rescale values of one frame, if it has its own.
void read_scale(const DicomValues& values, DicomSlice& slice) {
  const auto number = [&](std::uint32_t tag) {
    const auto found = values.find(tag);
    const auto all = found == values.end() ? std::vector<double>{} : decimal_numbers(found->second);
    return all.size() == 1 ? all[0] : std::nan("");
  };
  const double slope = number(0x00281053), intercept = number(0x00281052);
  if (!std::isfinite(slope) || slope == 0) return;
  slice.slope = slope;
  slice.intercept = std::isfinite(intercept) ? intercept : 0;
}

/// Pixels of one frame: an equal share of the bytes, or a fragment.
bool take_pixels(const DicomSlice& image, std::size_t frame, std::size_t count, DicomSlice& slice) {
  if (!image.is_compressed) {
    const std::uint64_t bits = std::uint64_t(image.rows) * std::uint64_t(image.columns) *
                               std::uint64_t(image.samples_per_pixel) * std::uint64_t(image.bits_allocated);
    const std::uint64_t size = (bits + 7) / 8, at = bits * frame / 8;
    slice.pixel_offset = image.pixel_offset + at;
    slice.pixel_length = image.pixel_length > at ? std::min(size, image.pixel_length - at) : 0;
    return true;
  }
  if (image.fragments.size() != count) return false;
  slice.fragments = {image.fragments[frame]};
  slice.pixel_length = slice.fragments[0].length;
  return true;
}

}  // namespace

std::vector<DicomSlice> frames_of(const DicomSlice& image, const DicomElements& set) {
  const std::size_t count = set.frames.size();
  if (image.frames < 1 || std::size_t(image.frames) != count) return {};
  std::vector<DicomSlice> frames;
  for (std::size_t f = 0; f < count; f++) {
    DicomSlice slice = image;
    slice.frames = 1;
    slice.frame = int(f) + 1;
    for (const DicomValues& shared : set.shared) read_geometry(shared, slice), read_scale(shared, slice);
    read_geometry(set.frames[f], slice), read_scale(set.frames[f], slice);
    if (!take_pixels(image, f, count, slice)) return {};
    frames.push_back(std::move(slice));
  }
  return frames;
}

}  // namespace turgor::io
