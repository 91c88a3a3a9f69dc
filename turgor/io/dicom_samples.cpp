// The samples of one DICOM slice in Hounsfield units.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <type_traits>

#include <fmt/format.h>

#include "turgor/io/dicom.hpp"

namespace turgor::io {

namespace {

/// Stored → HU. T is the type that holds a stored value; its bits above bits_stored may be anything.
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

Result<ChangedSamples> read_plain_samples(const DicomSlice& slice, std::span<std::int16_t> hu) {
  const std::size_t wanted = hu.size() * std::size_t(slice.bits_allocated) / 8;
  std::vector<char> stored(wanted);
  std::ifstream stream(slice.file, std::ios::binary);
  stream.seekg(std::streamoff(slice.pixel_offset));
  stream.read(stored.data(), std::streamsize(wanted));
  const auto found = std::size_t(std::max<std::streamsize>(stream.gcount(), 0));
  if (found < wanted || slice.pixel_length < wanted)
    return Error{fmt::format("{}: truncated or corrupt: {} bytes of pixels, expected {} ({} x {})",
                             slice.file.string(), found, wanted, slice.columns, slice.rows)};
  return convert_to_hu(slice, stored.data(), hu);
}

}  // namespace turgor::io
