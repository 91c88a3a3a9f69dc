// The headers of DICOM files, and of all files of a folder.
#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "turgor/io/dicom.hpp"
#include "turgor/io/dicom_elements.hpp"
#include "turgor/io/header_text.hpp"

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

Result<std::vector<fs::path>> list_files(const fs::path& folder, bool recursive) {
  constexpr std::size_t kMost = 200000;
  std::vector<fs::path> files;
  std::error_code failed;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto it = fs::recursive_directory_iterator(folder, options, failed);
       !failed && it != fs::recursive_directory_iterator(); it.increment(failed)) {
    std::error_code unknown;
    if (!recursive || it->path().filename().string().starts_with('.')) it.disable_recursion_pending();
    if (it->is_regular_file(unknown)) files.push_back(it->path());
    if (files.size() > kMost)
      return Error{
          fmt::format("{}: holds more than {} files; expected the folder of one CT", folder.string(), kMost)};
  }
  if (failed) return Error{fmt::format("{}: cannot be listed: {}", folder.string(), failed.message())};
  std::sort(files.begin(), files.end());
  return files;
}

std::string first_bytes(const fs::path& file, std::uint64_t count) {
  std::string bytes(std::size_t(count), '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), std::streamsize(bytes.size()));
  bytes.resize(std::size_t(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
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

Result<std::optional<DicomSlice>> read_dicom_header(const fs::path& file) {
  if (!is_dicom(file)) return std::optional<DicomSlice>{};
  constexpr std::uint64_t kUsual = std::uint64_t{1} << 15;  // most headers are shorter
  std::error_code failed;
  const std::uint64_t size = fs::file_size(file, failed);
  std::string bytes = first_bytes(file, std::min(size, kUsual));
  Result<DicomElements> found = find_elements(bytes, size);
  if ((!found || found->is_encapsulated) && size > kUsual) {
    bytes = first_bytes(file, size);
    found = find_elements(bytes, size);
  }
  if (!found && (bytes.size() < 132 || bytes.compare(128, 4, "DICM") != 0))
    return std::optional<DicomSlice>{};  // something else after all
  if (!found)
    return Error{
        fmt::format("{}: truncated or corrupt DICOM file: {}", file.string(), found.error().message)};
  DicomSlice slice = describe(file, size, *found);
  if (slice.rows <= 0 || slice.columns <= 0)
    return std::optional<DicomSlice>{};  // a directory, a report, contours
  return std::optional(std::move(slice));
}

Result<DicomFolder> scan_dicom(const Exec& exec, const fs::path& folder, bool recursive,
                               const Progress& progress) {
  const Result<std::vector<fs::path>> files = list_files(folder, recursive);
  if (!files) return files.error();
  std::vector<std::optional<Result<std::optional<DicomSlice>>>> headers(files->size());
  std::atomic<std::size_t> done{0};
  parallel_for(exec, headers.size(), [&](std::size_t i) {
    headers[i] = read_dicom_header((*files)[i]);
    if (progress) progress(double(++done) / double(headers.size()));
  });
  DicomFolder found{.slices = {}, .unreadable = {}, .file_count = files->size()};
  for (auto& header : headers) {
    if (!*header)
      found.unreadable.push_back(header->error().message);
    else if (**header)
      found.slices.push_back(std::move(***header));
  }
  return found;
}

}  // namespace turgor::io
