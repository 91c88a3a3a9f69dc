// Headers of DICOM files.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/dicom/dicom_elements.hpp"
#include "turgor/io/files/header_text.hpp"
#include "turgor/io/files/input_file.hpp"

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

std::vector<double> numbers(const DicomElements& set, std::uint16_t group, std::uint16_t element) {
  return decimal_numbers(set.value(group, element));
}

double number(const DicomElements& set, std::uint16_t group, std::uint16_t element, double otherwise) {
  const std::vector<double> values = numbers(set, group, element);
  return values.size() == 1 ? values[0] : otherwise;
}

void read_pixel_layout(const DicomElements& set, DicomSlice& slice) {
  const auto stored = [&](std::uint16_t element, bool is_signed) {
    return short_integer(set.value(0x0028, element), is_signed, set.is_big_endian);
  };
  const auto integer = [&](std::uint16_t element, int otherwise) {
    return stored(element, false).value_or(otherwise);
  };
  slice.samples_per_pixel = integer(0x0002, 1);
  slice.rows = integer(0x0010, 0);
  slice.columns = integer(0x0011, 0);
  slice.bits_allocated = integer(0x0100, 16);
  slice.bits_stored = integer(0x0101, slice.bits_allocated);
  slice.high_bit = integer(0x0102, slice.bits_stored - 1);
  slice.is_signed = integer(0x0103, 0) == 1;
  slice.photometric = text(set, 0x0028, 0x0004);
  const double frames = number(set, 0x0028, 0x0008, 1);
  slice.frames = frames >= 1 && frames <= 1e9 && frames == std::floor(frames) ? int(frames) : 0;
  slice.padding = stored(0x0120, slice.is_signed);
  slice.padding_limit = stored(0x0121, slice.is_signed);
  slice.slope = number(set, 0x0028, 0x1053, 1);
  slice.intercept = number(set, 0x0028, 0x1052, 0);
  if (!std::isfinite(slice.slope) || slice.slope == 0) slice.slope = 1, slice.intercept = 0;
  if (!std::isfinite(slice.intercept)) slice.intercept = 0;
}

/// Character set, study and patient, frame of reference. [DICOM PS3.3, C.7.1, C.7.2, C.7.4]
std::map<std::uint32_t, std::string> of_study(const DicomElements& set) {
  std::map<std::uint32_t, std::string> kept;
  for (const std::uint32_t tag : {0x00080005u, 0x00080020u, 0x00080030u, 0x00080050u, 0x00080090u,
                                  0x00081030u, 0x00100010u, 0x00100020u, 0x00100030u, 0x00100040u,
                                  0x00185100u, 0x0020000du, 0x00200010u, 0x00200052u, 0x00201040u})
    if (const auto found = set.values.find(tag); found != set.values.end()) kept.insert(*found);
  return kept;
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
  slice.image = text(set, 0x0008, 0x0018);
  slice.image_class = text(set, 0x0008, 0x0016);
  slice.of_study = of_study(set);
  read_pixel_layout(set, slice);
  slice.is_big_endian = set.is_big_endian;
  slice.is_deflated = set.is_deflated;
  slice.dataset_offset = set.dataset_offset;
  read_geometry(set.values, slice);
  return slice;
}

constexpr std::string_view kCtImage = "1.2.840.10008.5.1.4.1.1.2";  // also the prefix of enhanced ones

/// SOP class of the file's object.
std::string object_class(const DicomElements& set) {
  const std::string own = text(set, 0x0008, 0x0016);
  return own.empty() ? set.media_class : own;
}

/// Classifies a file without rows of pixels: a directory, a report, contours, or a truncated image.
void judge_without_image(const DicomElements& set, DicomFile& result) {
  const std::string kind = object_class(set);
  result.problem = "truncated or corrupt DICOM file: no Rows (0028,0010), no Columns (0028,0011)";
  if (kind.empty() || kind == kCtImage || kind.starts_with(std::string(kCtImage) + ".")) return;
  result.kind = DicomFile::Kind::kOtherObject;
  result.problem = "a DICOM file without an image";
}

}  // namespace

std::vector<double> decimal_numbers(std::string_view all) {
  std::vector<double> values;
  all = all.substr(0, all.find('\0'));
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\\', at), all.size());
    std::string word = trimmed(all.substr(at, end - at));
    if (word.starts_with('+')) word.erase(0, 1);
    double value = std::nan("");
    const char* const last = word.data() + word.size();
    if (std::from_chars(word.data(), last, value).ptr != last) value = std::nan("");
    values.push_back(value);
    at = end + 1;
  }
  return values;
}

std::optional<int> short_integer(std::string_view value, bool is_signed, bool is_big_endian) {
  if (value.size() < 2) return std::nullopt;
  const auto low = static_cast<unsigned char>(value[is_big_endian]),
             high = static_cast<unsigned char>(value[!is_big_endian]);
  const auto number = static_cast<std::uint16_t>(high << 8 | low);
  return is_signed ? int(static_cast<std::int16_t>(number)) : int(number);
}

void read_geometry(const DicomValues& values, DicomSlice& slice) {
  const auto finite = [&](std::uint32_t tag, std::size_t count) -> std::optional<std::vector<double>> {
    const auto found = values.find(tag);
    if (found == values.end()) return std::nullopt;
    std::vector<double> v = decimal_numbers(found->second);
    if (v.size() != count || !std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); }))
      return std::nullopt;
    return v;
  };
  if (const auto p = finite(0x00200032, 3)) slice.position = Vec3d{(*p)[0], (*p)[1], (*p)[2]};
  if (const auto d = finite(0x00200037, 6)) {
    slice.row_direction = {(*d)[0], (*d)[1], (*d)[2]};
    slice.column_direction = {(*d)[3], (*d)[4], (*d)[5]};
  }
  if (const auto s = finite(0x00280030, 2)) slice.row_spacing = (*s)[0], slice.column_spacing = (*s)[1];
  if (const auto t = finite(0x00180050, 1)) slice.thickness = (*t)[0];
}

bool is_dicom(const fs::path& file) {
  char start[132] = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(start, sizeof start);
  if (stream.gcount() == sizeof start && std::memcmp(start + 128, "DICM", 4) == 0) return true;
  // Without the preamble: the first element is of group 0002 or 0008 with a low number.
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
  if (!is_dicom(file)) return no_dicom("is not a DICOM file");
  DicomElements set;
  const Status found = find_elements(window, set);
  if (!found && !set.has_magic) return no_dicom("is not a DICOM file");
  if (set.has(0x0020, 0x000e)) result.series = text(set, 0x0020, 0x000e);
  if (!found)
    result.problem = found.error().message;
  else if (DicomSlice slice = describe(file, window.size(), set); slice.rows > 0 && slice.columns > 0) {
    if (!set.frames.empty()) result.frames = frames_of(slice, set);
    result.slice = std::move(slice);
  } else
    judge_without_image(set, result);
  return result;
}

}  // namespace turgor::io
