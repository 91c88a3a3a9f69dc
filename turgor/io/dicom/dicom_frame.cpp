// Image size inside compressed pixels. A decoder allocates memory for this size, whatever the DICOM header
// says.
#include <algorithm>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

namespace {

struct FrameSize {
  std::uint64_t rows = 0, columns = 0;
};

/// Big-endian number; 0 past the end.
std::uint64_t number(std::string_view code, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = at; i < at + bytes; i++)
    value = value << 8 | (i < code.size() ? static_cast<unsigned char>(code[i]) : 0);
  return value;
}

/// JPEG 2000 image size: end minus offset, after the start of the codestream. [ISO 15444-1, A.5.1]
std::optional<FrameSize> size_of_j2k(std::string_view code) {
  const std::size_t start = code.find(std::string_view("\xff\x4f\xff\x51", 4));
  if (start == code.npos || code.size() < start + 24) return std::nullopt;
  const std::size_t at = start + 8;  // after both markers, the segment's length and its capabilities
  const std::uint64_t right = number(code, at, 4), bottom = number(code, at + 4, 4),
                      left_edge = number(code, at + 8, 4), top = number(code, at + 12, 4);
  if (right < left_edge || bottom < top) return std::nullopt;
  return FrameSize{bottom - top, right - left_edge};
}

/// JPEG and JPEG-LS: segments up to a start of frame. [ITU T.81, B.2.2; T.87, C.2.2]
std::optional<FrameSize> size_of_jpeg(std::string_view code) {
  if (!code.starts_with("\xff\xd8")) return std::nullopt;
  for (std::size_t at = 2; at + 9 <= code.size();) {
    const std::uint64_t mark = number(code, at, 2);
    if (mark == 0xffff) {
      at++;  // fill bytes
      continue;
    }
    if (mark < 0xffc0) return std::nullopt;
    const bool is_frame =
        mark == 0xfff7 || (mark <= 0xffcf && mark != 0xffc4 && mark != 0xffc8 && mark != 0xffcc);
    if (is_frame) return FrameSize{number(code, at + 5, 2), number(code, at + 7, 2)};
    at += 2 + std::size_t(number(code, at + 2, 2));
  }
  return std::nullopt;
}

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string first_code(const DicomSlice& slice) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 18;  // color profiles may come first
  if (slice.fragments.empty()) return {};
  std::string code(std::size_t(std::min(slice.fragments[0].length, kMost)), '\0');
  std::ifstream stream(slice.file, std::ios::binary);
  stream.seekg(std::streamoff(slice.fragments[0].offset));
  stream.read(code.data(), std::streamsize(code.size()));
  code.resize(std::size_t(std::max<std::streamsize>(stream.gcount(), 0)));
  return code;
}

}  // namespace

Status check_frame(const DicomSlice& slice) {
  constexpr std::string_view kJpeg = "1.2.840.10008.1.2.4.";
  if (!std::string_view(slice.transfer_syntax).starts_with(kJpeg))
    return Done{};  // run-length encoding has no size
  const std::string code = first_code(slice);
  const std::string_view kind = std::string_view(slice.transfer_syntax).substr(kJpeg.size());
  const auto size = is_one_of(kind, {"90", "91", "92", "93"}) ? size_of_j2k(code) : size_of_jpeg(code);
  if (!size)
    return Error{fmt::format(
        "{}: damaged, or compressed in an unknown way: the pixels cannot be decoded (transfer syntax {}, no "
        "image size in them)",
        slice.file.string(), slice.transfer_syntax)};
  if (size->rows == std::uint64_t(slice.rows) && size->columns == std::uint64_t(slice.columns)) return Done{};
  return Error{fmt::format("{}: corrupt: the header declares {} x {} pixels, the compressed pixels {} x {}",
                           slice.file.string(), slice.columns, slice.rows, size->columns, size->rows)};
}

}  // namespace turgor::io
