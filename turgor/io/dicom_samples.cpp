// The samples of one DICOM slice in Hounsfield units. Uncompressed files are converted straight from GDCM's bytes; GDCM
// decodes all others.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <istream>
#include <type_traits>

#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>

#include "turgor/io/dicom.hpp"
#include "turgor/io/dicom_stream.hpp"
#include "turgor/io/file.hpp"

namespace turgor::io {

namespace {

Error damaged(const DicomSlice& slice, std::size_t found, std::size_t wanted) {
  return {fmt::format("{}: truncated or corrupt: {} bytes of pixels, expected {} ({} x {})", slice.file.string(), found, wanted,
                      slice.columns, slice.rows)};
}

/// Stored → HU. T is the type that holds a stored value; its bits above bits_stored may be anything.
template <class T>
void convert(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu) {
  using Wide = std::conditional_t<sizeof(T) == 4, std::int64_t, std::int32_t>;
  const int unused = int(sizeof(T)) * 8 - slice.bits_stored;
  const float slope = float(slice.slope), intercept = float(slice.intercept);
  const bool padded = slice.padding.has_value();
  const Wide pad = Wide(slice.padding.value_or(0)), limit = Wide(slice.padding_limit.value_or(slice.padding.value_or(0)));
  const Wide pad_low = std::min(pad, limit), pad_high = std::max(pad, limit);
  for (std::size_t i = 0; i < hu.size(); i++) {
    T raw;
    std::memcpy(&raw, stored + i * sizeof(T), sizeof(T));
    const Wide value = static_cast<T>(static_cast<T>(static_cast<std::make_unsigned_t<T>>(raw) << unused) >> unused);
    const float scaled = std::nearbyint(slope * float(value) + intercept);
    const bool padding = padded && value >= pad_low && value <= pad_high;
    hu[i] = padding ? kAirHu : std::int16_t(std::clamp(scaled, -32768.0f, 32767.0f));
  }
}

void convert_any(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu) {
  switch (slice.bits_allocated) {
    case 8: return slice.is_signed ? convert<std::int8_t>(slice, stored, hu) : convert<std::uint8_t>(slice, stored, hu);
    case 16: return slice.is_signed ? convert<std::int16_t>(slice, stored, hu) : convert<std::uint16_t>(slice, stored, hu);
    default: return slice.is_signed ? convert<std::int32_t>(slice, stored, hu) : convert<std::uint32_t>(slice, stored, hu);
  }
}

Error cut_short(const DicomSlice& slice) {
  return {fmt::format("{}: truncated or corrupt: {} bytes end before the pixels do", slice.file.string(), slice.file_size)};
}

Status read_plain(const DicomSlice& slice, WholeFile& bytes_of_file, std::span<std::int16_t> hu) {
  const std::size_t wanted = hu.size() * std::size_t(slice.bits_allocated) / 8;
  const gdcm::Tag pixels(0x7fe0, 0x0010);
  std::istream stream(&bytes_of_file);
  gdcm::Reader reader;
  reader.SetStream(stream);
  const bool is_read = reader.Read();
  if (bytes_of_file.is_cut_short()) return cut_short(slice);
  if (!is_read) return damaged(slice, 0, wanted);
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const gdcm::ByteValue* bytes = set.FindDataElement(pixels) ? set.GetDataElement(pixels).GetByteValue() : nullptr;
  if (!bytes || bytes->GetLength() < wanted) return damaged(slice, bytes ? std::size_t(bytes->GetLength()) : 0, wanted);
  convert_any(slice, bytes->GetPointer(), hu);
  return Done{};
}

Status decode(const DicomSlice& slice, WholeFile& bytes_of_file, std::span<std::int16_t> hu) {
  std::istream stream(&bytes_of_file);
  gdcm::ImageReader reader;
  reader.SetStream(stream);
  const bool is_read = reader.Read();
  if (bytes_of_file.is_cut_short()) return cut_short(slice);
  if (!is_read) return Error{fmt::format("{}: the pixels cannot be decoded: damaged, or compressed in an unknown way", slice.file.string())};
  const gdcm::Image& image = reader.GetImage();
  const gdcm::PixelFormat format = image.GetPixelFormat();
  DicomSlice decoded = slice;
  decoded.bits_allocated = format.GetBitsAllocated();
  decoded.bits_stored = format.GetBitsStored();
  decoded.is_signed = format.GetPixelRepresentation() == 1;
  const std::size_t wanted = hu.size() * std::size_t(decoded.bits_allocated) / 8, found = image.GetBufferLength();
  const bool sane = decoded.bits_allocated == 8 || decoded.bits_allocated == 16 || decoded.bits_allocated == 32;
  if (!sane || format.GetSamplesPerPixel() != 1 || found != wanted) return damaged(slice, found, wanted);
  std::vector<char> buffer(found);
  if (!image.GetBuffer(buffer.data())) return damaged(slice, 0, wanted);
  convert_any(decoded, buffer.data(), hu);
  return Done{};
}

}  // namespace

Status read_dicom_samples(const DicomSlice& slice, std::span<std::int16_t> hu) {
  try {
    Result<std::string> bytes = read_file(slice.file);
    if (!bytes) return bytes.error();
    WholeFile file(std::move(*bytes));
    return slice.is_compressed ? decode(slice, file, hu) : read_plain(slice, file, hu);
  } catch (const std::exception& error) {
    return Error{fmt::format("{}: damaged DICOM file: {}", slice.file.string(), error.what())};
  }
}

}  // namespace turgor::io
