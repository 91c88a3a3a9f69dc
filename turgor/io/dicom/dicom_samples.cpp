// Samples of one DICOM slice in Hounsfield units.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <type_traits>

#include <fmt/format.h>

#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

namespace {

/// Stored values to HU. T is the type of a stored value; its bits above bits_stored are undefined.
template <class T>
ChangedSamples convert(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu) {
  using Wide = std::conditional_t<sizeof(T) == 4, std::int64_t, std::int32_t>;
  const int unused = int(sizeof(T)) * 8 - slice.bits_stored;
  const float slope = float(slice.slope), intercept = float(slice.intercept);
  const bool padded = slice.padding.has_value();
  const Wide pad = Wide(slice.padding.value_or(0)),
             limit = Wide(slice.padding_limit.value_or(slice.padding.value_or(0)));
  const Wide pad_low = std::min(pad, limit), pad_high = std::max(pad, limit);
  ChangedSamples changed;
  for (std::size_t i = 0; i < hu.size(); i++) {
    T raw;
    std::memcpy(&raw, stored + i * sizeof(T), sizeof(T));
    const Wide value =
        static_cast<T>(static_cast<T>(static_cast<std::make_unsigned_t<T>>(raw) << unused) >> unused);
    const float scaled = std::nearbyint(slope * float(value) + intercept);
    const bool padding = padded && value >= pad_low && value <= pad_high;
    const float kept = std::clamp(scaled, -32768.0f, 32767.0f);
    hu[i] = padding ? kAirHu : std::int16_t(kept);
    changed.padding += padding;
    changed.clamped += !padding && kept != scaled;
  }
  return changed;
}

}  // namespace

ChangedSamples convert_to_hu(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu) {
  switch (slice.bits_allocated) {
    case 8:
      return slice.is_signed ? convert<std::int8_t>(slice, stored, hu)
                             : convert<std::uint8_t>(slice, stored, hu);
    case 16:
      return slice.is_signed ? convert<std::int16_t>(slice, stored, hu)
                             : convert<std::uint16_t>(slice, stored, hu);
    default:
      return slice.is_signed ? convert<std::int32_t>(slice, stored, hu)
                             : convert<std::uint32_t>(slice, stored, hu);
  }
}

namespace {

/// Swaps bytes in words of two, also for one-byte samples. [PS3.5, 8.1.1 and annex A.3]
void swap_bytes(std::string& stored, int bits_allocated) {
  const std::size_t size = bits_allocated == 32 ? 4 : 2;
  for (std::size_t at = 0; at + size <= stored.size(); at += size)
    std::reverse(stored.begin() + std::ptrdiff_t(at), stored.begin() + std::ptrdiff_t(at + size));
}

}  // namespace

std::string stored_bytes(const DicomSlice& slice, InflatedStream* inflated, std::size_t byte_count) {
  std::string stored(byte_count, '\0');
  if (inflated) {
    stored.resize(inflated->read(slice.pixel_offset, stored));
    return stored;
  }
  std::ifstream stream(slice.file, std::ios::binary);
  stream.seekg(std::streamoff(slice.pixel_offset));
  stream.read(stored.data(), std::streamsize(byte_count));
  stored.resize(std::size_t(std::max<std::streamsize>(stream.gcount(), 0)));
  return stored;
}

Result<ChangedSamples> read_plain_samples(const DicomSlice& slice, InflatedStream* inflated,
                                          std::span<std::int16_t> hu) {
  const std::size_t byte_count = hu.size() * std::size_t(slice.bits_allocated) / 8;
  std::string stored =
      stored_bytes(slice, inflated, std::size_t(std::min<std::uint64_t>(byte_count, slice.pixel_length)));
  const std::size_t found = stored.size();
  if (found < byte_count)
    return Error{fmt::format("{}: truncated or corrupt: {} bytes of pixels, expected {} ({} x {})",
                             slice.file.string(), found, byte_count, slice.columns, slice.rows)};
  if (slice.is_big_endian) swap_bytes(stored, slice.bits_allocated);
  return convert_to_hu(slice, stored.data(), hu);
}

}  // namespace turgor::io
