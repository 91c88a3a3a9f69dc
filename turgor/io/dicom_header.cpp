// The headers of DICOM files.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "turgor/io/dicom.hpp"
#include "turgor/io/dicom_elements.hpp"
#include "turgor/io/header_text.hpp"
#include "turgor/io/input_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

std::string text(const DicomElements& set, std::uint16_t group, std::uint16_t element) {
  std::string_view raw = set.value(group, element);
  std::string clean = trimmed(raw.substr(0, raw.find('\0')));
  for (char& c : clean)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return clean;
}

/// Decimal strings: "1.5\2\-3e1". Words that are no numbers become NaN.
std::vector<double> numbers(const DicomElements& set, std::uint16_t group, std::uint16_t element) {
  std::vector<double> values;
  const std::string all = text(set, group, element);
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\\', at), all.size());
    std::string word = trimmed(std::string_view(all).substr(at, end - at));
    if (word.starts_with('+')) word.erase(0, 1);
    double value = std::nan("");
    std::from_chars(word.data(), word.data() + word.size(), value);
    values.push_back(value);
    at = end + 1;
  }
  return values;
}

double number(const DicomElements& set, std::uint16_t group, std::uint16_t element, double otherwise) {
  const std::vector<double> values = numbers(set, group, element);
  return values.size() == 1 ? values[0] : otherwise;
}

std::optional<int> short_integer(const DicomElements& set, std::uint16_t group, std::uint16_t element,
                                 bool is_signed) {
  const std::string_view raw = set.value(group, element);
  if (raw.size() < 2) return std::nullopt;
  std::uint16_t value;
  std::memcpy(&value, raw.data(), 2);
  return is_signed ? int(static_cast<std::int16_t>(value)) : int(value);
}

void read_pixel_layout(const DicomElements& set, DicomSlice& slice) {
  const auto integer = [&](std::uint16_t element, int otherwise) {
    return short_integer(set, 0x0028, element, false).value_or(otherwise);
  };
  slice.samples_per_pixel = integer(0x0002, 1);
  slice.rows = integer(0x0010, 0);
  slice.columns = integer(0x0011, 0);
  slice.bits_allocated = integer(0x0100, 16);
  slice.bits_stored = integer(0x0101, slice.bits_allocated);
  slice.high_bit = integer(0x0102, slice.bits_stored - 1);
  slice.is_signed = integer(0x0103, 0) == 1;
  slice.photometric = text(set, 0x0028, 0x0004);
  slice.frames = int(number(set, 0x0028, 0x0008, 1));
  slice.padding = short_integer(set, 0x0028, 0x0120, slice.is_signed);
  slice.padding_limit = short_integer(set, 0x0028, 0x0121, slice.is_signed);
  slice.slope = number(set, 0x0028, 0x1053, 1);
  slice.intercept = number(set, 0x0028, 0x1052, 0);
  if (!std::isfinite(slice.slope) || slice.slope == 0) slice.slope = 1, slice.intercept = 0;
  if (!std::isfinite(slice.intercept)) slice.intercept = 0;
}

void read_place(const DicomElements& set, DicomSlice& slice) {
  const auto finite = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  };
  if (const auto p = numbers(set, 0x0020, 0x0032); p.size() == 3 && finite(p))
    slice.position = Vec3d{p[0], p[1], p[2]};
  if (const auto d = numbers(set, 0x0020, 0x0037); d.size() == 6 && finite(d)) {
    slice.row_direction = {d[0], d[1], d[2]};
    slice.column_direction = {d[3], d[4], d[5]};
  }
  if (const auto s = numbers(set, 0x0028, 0x0030); s.size() == 2 && finite(s))
    slice.row_spacing = s[0], slice.column_spacing = s[1];
  slice.thickness = number(set, 0x0018, 0x0050, 0);
}

DicomSlice describe(const fs::path& file, std::uint64_t file_size, const DicomElements& set) {
  DicomSlice slice;
  slice.file = file;
  slice.file_size = file_size;
  slice.is_compressed = set.is_encapsulated;
  slice.pixel_offset = set.pixel_offset;
  slice.pixel_length = set.pixel_length;
  slice.fragments = set.fragments;
  slice.transfer_syntax = set.transfer_syntax;
  slice.series = text(set, 0x0020, 0x000e);
  slice.description = text(set, 0x0008, 0x103e);
  slice.modality = text(set, 0x0008, 0x0060);
  slice.patient = text(set, 0x0010, 0x0010);
  slice.study = text(set, 0x0008, 0x1030);
  slice.image_type = text(set, 0x0008, 0x0008);
  read_pixel_layout(set, slice);
  read_place(set, slice);
  return slice;
}

constexpr std::string_view kCtImage = "1.2.840.10008.5.1.4.1.1.2";  // and enhanced ones behind a point

/// What kind of object the file says it is: its SOP class.
std::string object_class(const DicomElements& set) {
  const std::string own = text(set, 0x0008, 0x0016);
  return own.empty() ? set.media_class : own;
}

/// A file without rows of pixels: a directory, a report, contours; or an image that ends too early.
void judge_without_image(const DicomElements& set, DicomFile& result) {
  const std::string kind = object_class(set);
  result.problem = "truncated or corrupt DICOM file: no Rows (0028,0010), no Columns (0028,0011)";
  if (kind.empty() || kind == kCtImage || kind.starts_with(std::string(kCtImage) + ".")) return;
  result.kind = DicomFile::Kind::kOtherObject;
  result.problem = "a DICOM file without an image";
}

}  // namespace

bool is_dicom(const fs::path& file) {
  char start[132] = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(start, sizeof start);
  if (stream.gcount() == sizeof start && std::memcmp(start + 128, "DICM", 4) == 0) return true;
  // Without the preamble: the first element is of group 0002 or 0008, at a low number.
  return stream.gcount() >= 8 && (start[0] == 2 || start[0] == 8) && start[1] == 0 && start[3] == 0;
}

DicomFile read_dicom_header(const fs::path& file) {
  const auto no_dicom = [&](const char* why) {
    return DicomFile{
        .file = file, .slice = {}, .problem = why, .series = {}, .kind = DicomFile::Kind::kNoDicom};
  };
  DicomFile result{.file = file, .slice = {}, .problem = {}, .series = {}};
  if (const Status input = check_input(file); !input) {
    result.problem = input.error().message.substr(file.string().size() + 2);
    return result;
  }
  FileWindow window(file);
  if (window.size() == 0) return no_dicom("is empty");
  if (!is_dicom(file)) return no_dicom("is no DICOM file");
  DicomElements set;
  const Status found = find_elements(window, set);
  if (!found && !set.has_magic) return no_dicom("is no DICOM file");
  if (set.has(0x0020, 0x000e)) result.series = text(set, 0x0020, 0x000e);
  if (!found)
    result.problem = found.error().message;
  else if (DicomSlice slice = describe(file, window.size(), set); slice.rows > 0 && slice.columns > 0)
    result.slice = std::move(slice);
  else
    judge_without_image(set, result);
  return result;
}

}  // namespace turgor::io
