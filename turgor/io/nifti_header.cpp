// The NIfTI-1 header: 348 bytes in either byte order. Places the grid as nibabel and 3D Slicer do (sform,
// else qform, else the spacing alone) and turns it from RAS to LPS.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "turgor/io/volume_header.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

class Fields {
 public:
  explicit Fields(std::string_view head) : head_(head), swap_(get<std::int32_t>(0, false) != 348) {}

  template <class T>
  T get(std::size_t at) const {
    return get<T>(at, swap_);
  }
  bool is_nifti1() const { return get<std::int32_t>(0) == 348; }
  bool is_swapped() const { return swap_; }

 private:
  template <class T>
  T get(std::size_t at, bool swap) const {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), head_.data() + at, sizeof(T));
    if (swap) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }
  std::string_view head_;
  bool swap_;
};

bool sample_type(int code, SampleType& type) {
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
    const auto value = [&](int column) {
      return double(f.get<float>(std::size_t(280 + 16 * row + 4 * column)));
    };
    for (int column = 0; column < 3; column++) a.linear.column[column][row] = value(column);
    a.origin[row] = value(3);
  }
  return a;
}

Affine qform(const Fields& f) {
  const double b = f.get<float>(256), c = f.get<float>(260), d = f.get<float>(264);
  const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + d * d)));
  const double handed = f.get<float>(76) < 0 ? -1 : 1;
  const Vec3d i{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)};
  const Vec3d j{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)};
  const Vec3d k{2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b};
  return {{{i * double(f.get<float>(80)), j * double(f.get<float>(84)), k * (handed * f.get<float>(88))}},
          {f.get<float>(268), f.get<float>(272), f.get<float>(276)}};
}

Affine spacing_alone(const Fields& f) {
  return {{{{f.get<float>(80), 0, 0}, {0, f.get<float>(84), 0}, {0, 0, f.get<float>(88)}}}, {}};
}

double metres_per_unit(int units) { return (units & 7) == 1 ? 1 : (units & 7) == 3 ? 1e-6 : 1e-3; }

Status place(const fs::path& path, const Fields& f, VolumeHeader& header) {
  Affine a = f.get<std::int16_t>(254) > 0   ? sform(f)
             : f.get<std::int16_t>(252) > 0 ? qform(f)
                                            : spacing_alone(f);
  const double unit = metres_per_unit(f.get<std::uint8_t>(123));
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

Status read_sizes(const fs::path& path, const Fields& f, VolumeHeader& header) {
  const auto dim = [&](int axis) { return std::int64_t(f.get<std::int16_t>(std::size_t(40 + 2 * axis))); };
  const std::int64_t count = dim(0);
  if (count < 1 || count > 7)
    return Error{fmt::format("{}: {} dimensions; expected 3", path.string(), count)};
  for (int axis = 1; axis <= 7; axis++) {
    const std::int64_t size = axis <= count ? dim(axis) : 1;
    if (axis <= 3)
      header.size[std::size_t(axis - 1)] = size;
    else if (axis == 5 && dim(4) == 1 && size >= 1)
      header.components *= int(size);
    else if (size != 1)
      return Error{fmt::format("{}: {} samples along dimension {}; expected one volume (3 dimensions)",
                               path.string(), size, axis)};
  }
  return Done{};
}

/// Extensions lie between the header and the samples: size, kind, and a text in those that interest us.
/// TotalSegmentator says kind 0, others 6 (a comment), Caret 30.
void read_extensions(const Fields& f, std::string_view head, VolumeHeader& header) {
  const std::size_t end = std::min(head.size(), std::size_t(header.data_offset));
  if (head[348] == 0) return;
  for (std::size_t at = 352; at + 8 <= end;) {
    const auto size = f.get<std::int32_t>(at);
    if (size < 8 || std::size_t(size) > end - at) return;
    if (header.label_names.empty())
      header.label_names = label_names_in(head.substr(at + 8, std::size_t(size) - 8));
    at += std::size_t(size);
  }
}

}  // namespace

Result<VolumeHeader> parse_nifti(const fs::path& path, std::string_view head) {
  if (head.size() < 352)
    return Error{fmt::format("{}: truncated: {} bytes, a NIfTI header has 352", path.string(), head.size())};
  const Fields f(head);
  if (!f.is_nifti1())
    return Error{fmt::format("{}: NIfTI-2 or a corrupt NIfTI header; expected NIfTI-1", path.string())};
  if (head.substr(344, 4) != std::string_view("n+1", 4))
    return Error{fmt::format(
        "{}: an Analyze or two-file NIfTI header; expected a single file (.nii or .nii.gz)", path.string())};
  if (!path.string().ends_with(".nii") && !path.string().ends_with(".nii.gz"))
    return Error{fmt::format("{}: holds NIfTI; expected its name to end in .nii or .nii.gz", path.string())};
  VolumeHeader header{.format = VolumeFormat::kNifti, .is_swapped = f.is_swapped(), .data_file = path};
  const int code = f.get<std::int16_t>(70);
  if (!sample_type(code, header.type))
    return Error{fmt::format("{}: NIfTI sample type {} is not read; expected whole or real numbers",
                             path.string(), code)};
  const int expected_bits = int(byte_size(header.type)) * 8;
  if (f.get<std::int16_t>(72) != expected_bits)
    return Error{fmt::format("{}: corrupt: {} bits a sample, type {} has {}", path.string(),
                             f.get<std::int16_t>(72), code, expected_bits)};
  if (Status sizes = read_sizes(path, f, header); !sizes) return sizes.error();
  header.component_stride = header.components > 1 ? header.size[0] * header.size[1] * header.size[2] : 1;
  if (Status placed = place(path, f, header); !placed) return placed.error();
  const double offset = f.get<float>(108);
  if (!(offset >= 352 && offset < 1e9) || offset != std::floor(offset))
    return Error{
        fmt::format("{}: corrupt: samples start at byte {}; expected 352 or more", path.string(), offset)};
  header.data_offset = std::int64_t(offset);
  read_extensions(f, head, header);
  const double slope = f.get<float>(112), intercept = f.get<float>(116);
  if (std::isfinite(slope) && slope != 0)
    header.slope = slope, header.intercept = std::isfinite(intercept) ? intercept : 0;
  return header;
}

}  // namespace turgor::io
