// Headers of NIfTI-1 (348 bytes) and NIfTI-2 (540 bytes), in either byte order. The grid is that of the
// sform, else of the qform, and is converted from RAS to LPS. Without both it has the spacing alone, as in 3D
// Slicer; nibabel then flips x and centers the grid. [nifti1.h, nifti2.h of the NIfTI working group]
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "turgor/io/volume/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

namespace {

constexpr int kSize1 = 348, kSize2 = 540;  // of the headers [bytes]

/// Fields of both versions, which differ in offset and width.
class Fields {
 public:
  explicit Fields(std::string_view head) : head_(head) {
    const auto size = get<std::int32_t>(0, false), swapped = get<std::int32_t>(0, true);
    swap_ = size != kSize1 && size != kSize2;
    size_ = swap_ ? swapped : size;
  }

  template <class T>
  T get(std::size_t at) const {
    return get<T>(at, swap_);
  }
  int header_size() const { return size_; }
  bool is_known() const { return size_ == kSize1 || size_ == kSize2; }
  bool is_swapped() const { return swap_; }
  /// A single file, whose magic matches the header size.
  bool has_magic() const {
    return is_2() ? head_.substr(4, 8) == "n+2\0\r\n\032\n"sv : head_.substr(344, 4) == "n+1\0"sv;
  }

  int type() const { return get<std::int16_t>(is_2() ? 12 : 70); }
  int bits() const { return get<std::int16_t>(is_2() ? 14 : 72); }
  std::int64_t dim(int n) const {
    return is_2() ? get<std::int64_t>(at(16, 8, n)) : get<std::int16_t>(at(40, 2, n));
  }
  double pixdim(int n) const { return real(104, 76, n); }
  double offset() const { return is_2() ? double(get<std::int64_t>(168)) : double(get<float>(108)); }
  double slope() const { return real(176, 112, 0); }
  double intercept() const { return real(184, 116, 0); }
  int qform_code() const { return is_2() ? get<std::int32_t>(344) : get<std::int16_t>(252); }
  int sform_code() const { return is_2() ? get<std::int32_t>(348) : get<std::int16_t>(254); }
  double quatern(int n) const { return real(352, 256, n); }  // b, c, d; then the offset x, y, z
  double srow(int row, int column) const { return real(400, 280, 4 * row + column); }
  int units() const { return is_2() ? get<std::int32_t>(500) : get<std::uint8_t>(123); }

 private:
  bool is_2() const { return size_ == kSize2; }
  static std::size_t at(std::size_t begin, std::size_t size, int n) { return begin + size * std::size_t(n); }
  double real(std::size_t at_2, std::size_t at_1, int n) const {
    return is_2() ? get<double>(at(at_2, 8, n)) : double(get<float>(at(at_1, 4, n)));
  }
  template <class T>
  T get(std::size_t at, bool swap) const {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), head_.data() + at, sizeof(T));
    if (swap) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }
  std::string_view head_;
  bool swap_ = false;
  int size_ = 0;
};

bool nifti_type(int code, SampleType& type) {
  switch (code) {
    case 2:
      type = SampleType::kUint8;
      return true;
    case 4:
      type = SampleType::kInt16;
      return true;
    case 8:
      type = SampleType::kInt32;
      return true;
    case 16:
      type = SampleType::kFloat;
      return true;
    case 64:
      type = SampleType::kDouble;
      return true;
    case 256:
      type = SampleType::kInt8;
      return true;
    case 512:
      type = SampleType::kUint16;
      return true;
    case 768:
      type = SampleType::kUint32;
      return true;
    case 1024:
      type = SampleType::kInt64;
      return true;
    case 1280:
      type = SampleType::kUint64;
      return true;
    default:
      return false;
  }
}

struct Affine {
  Mat3d linear;  // columns: one step along i, j, k [mm]
  Vec3d origin;  // [mm]
};

Affine sform(const Fields& f) {
  Affine a;
  for (int row = 0; row < 3; row++) {
    for (int column = 0; column < 3; column++) a.linear.column[column][row] = f.srow(row, column);
    a.origin[row] = f.srow(row, 3);
  }
  return a;
}

Affine qform(const Fields& f) {
  const double b = f.quatern(0), c = f.quatern(1), d = f.quatern(2);
  const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + d * d)));
  const double handed = f.pixdim(0) < 0 ? -1 : 1;
  const Vec3d i{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)};
  const Vec3d j{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)};
  const Vec3d k{2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b};
  return {{{i * f.pixdim(1), j * f.pixdim(2), k * (handed * f.pixdim(3))}},
          {f.quatern(3), f.quatern(4), f.quatern(5)}};
}

Affine spacing_alone(const Fields& f) {
  return {{{{f.pixdim(1), 0, 0}, {0, f.pixdim(2), 0}, {0, 0, f.pixdim(3)}}}, {}};
}

double meters_per_unit(int units) { return (units & 7) == 1 ? 1 : (units & 7) == 3 ? 1e-6 : 1e-3; }

Status read_grid(const fs::path& path, const Fields& f, VolumeHeader& header) {
  Affine a = f.sform_code() > 0 ? sform(f) : f.qform_code() > 0 ? qform(f) : spacing_alone(f);
  if (f.sform_code() <= 0 && f.qform_code() <= 0) header.missing = "orientation";
  const double unit = meters_per_unit(f.units());
  for (int axis = 0; axis < 3; axis++) {
    const Vec3d ras = a.linear.column[axis];
    const double length = norm(ras);
    if (!(length > 0) || !std::isfinite(length))
      return Error{fmt::format("{}: spacing along axis {} is {} mm; expected a positive number",
                               path.string(), axis, length)};
    header.grid.spacing[axis] = length * unit;
    header.grid.axes.column[axis] = Vec3d{-ras.x, -ras.y, ras.z} / length;
  }
  header.grid.origin = Vec3d{-a.origin.x, -a.origin.y, a.origin.z} * unit;
  return Done{};
}

Status read_nifti_sizes(const fs::path& path, const Fields& f, VolumeHeader& header) {
  const std::int64_t count = f.dim(0);
  if (count < 1 || count > 7)
    return Error{fmt::format("{}: {} dimensions; expected 3", path.string(), count)};
  for (int axis = 1; axis <= 7; axis++) {
    const std::int64_t size = axis <= count ? f.dim(axis) : 1;
    if (axis <= 3)
      header.size[std::size_t(axis - 1)] = size;
    else if (axis == 5 && f.dim(4) == 1 && size >= 1 && size <= kMostComponents)
      header.components *= int(size);
    else if (size != 1)
      return Error{fmt::format("{}: {} samples along dimension {}; expected one volume (3 dimensions)",
                               path.string(), size, axis)};
  }
  return Done{};
}

/// Reads the extensions between header and samples: size, kind, and a text in the kinds of interest.
/// TotalSegmentator writes kind 0, others 6 (a comment), Caret 30.
void read_extensions(const Fields& f, std::string_view head, VolumeHeader& header) {
  const std::size_t end = std::min(head.size(), std::size_t(header.data_offset));
  const auto begin = std::size_t(f.header_size());
  if (head[begin] == 0) return;
  for (std::size_t at = begin + 4; at + 8 <= end;) {
    const auto size = f.get<std::int32_t>(at);
    if (size < 8 || std::size_t(size) > end - at) return;
    if (header.label_names.empty())
      header.label_names = label_names_in(head.substr(at + 8, std::size_t(size) - 8));
    at += std::size_t(size);
  }
}

}  // namespace

Result<VolumeHeader> parse_nifti(const fs::path& path, std::string_view head) {
  const Fields f(head);
  if (!f.is_known())
    return Error{fmt::format("{}: corrupt: header size of {} bytes; expected {} or {}", path.string(),
                             f.header_size(), kSize1, kSize2)};
  const auto least = std::size_t(f.header_size()) + 4;  // including the extension flag
  if (head.size() < least)
    return Error{
        fmt::format("{}: truncated: {} bytes, a NIfTI header has {}", path.string(), head.size(), least)};
  if (!f.has_magic())
    return Error{fmt::format(
        "{}: an Analyze or two-file NIfTI header; expected a single file (.nii or .nii.gz)", path.string())};
  if (!path.string().ends_with(".nii") && !path.string().ends_with(".nii.gz"))
    return Error{fmt::format("{}: holds NIfTI; expected its name to end in .nii or .nii.gz", path.string())};
  VolumeHeader header{.format = VolumeFormat::kNifti, .is_swapped = f.is_swapped(), .data_file = path};
  const int code = f.type();
  if (!nifti_type(code, header.type))
    return Error{fmt::format("{}: NIfTI sample type {} is not read; expected whole or real numbers",
                             path.string(), code)};
  const int expected_bits = int(byte_size(header.type)) * 8;
  if (f.bits() != expected_bits)
    return Error{fmt::format("{}: corrupt: {} bits a sample, type {} has {}", path.string(), f.bits(), code,
                             expected_bits)};
  if (Status sizes = read_nifti_sizes(path, f, header); !sizes) return sizes.error();
  if (Status extent = check_extent(path, header); !extent) return extent.error();
  header.component_stride = header.components > 1 ? header.size[0] * header.size[1] * header.size[2] : 1;
  if (Status grid = read_grid(path, f, header); !grid) return grid.error();
  const double offset = f.offset();
  if (!(offset >= double(least) && offset < 1e9) || offset != std::floor(offset))
    return Error{fmt::format("{}: corrupt: samples start at byte {}; expected {} or more", path.string(),
                             offset, least)};
  header.data_offset = std::int64_t(offset);
  read_extensions(f, head, header);
  const double slope = f.slope(), intercept = f.intercept();
  if (std::isfinite(slope) && slope != 0)
    header.slope = slope, header.intercept = std::isfinite(intercept) ? intercept : 0;
  return header;
}

}  // namespace turgor::io
