// Writing of NIfTI-1 files: header, then samples, compressed if the name says so. The grid is stored as an
// sform of scanner coordinates.
#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "turgor/io/files/deflate.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {

namespace {

int nifti_type(SampleType type) {
  switch (type) {
    case SampleType::kInt8:
      return 256;
    case SampleType::kUint8:
      return 2;
    case SampleType::kInt16:
      return 4;
    case SampleType::kUint16:
      return 512;
    case SampleType::kInt32:
      return 8;
    case SampleType::kUint32:
      return 768;
    case SampleType::kInt64:
      return 1024;
    case SampleType::kUint64:
      return 1280;
    case SampleType::kFloat:
      return 16;
    default:
      return 64;
  }
}

class Header {
 public:
  template <class T>
  void put(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  const std::array<char, 352>& bytes() const { return bytes_; }

 private:
  std::array<char, 352> bytes_{};
};

void put_grid(Header& header, const Grid& grid) {
  header.put<float>(76, 1);
  header.put<std::int16_t>(254, 1);  // sform: scanner coordinates, RAS
  for (int row = 0; row < 3; row++) {
    const double sign = row < 2 ? -1e3 : 1e3;  // LPS [m] to RAS [mm]
    const auto put = [&](int column, double value) {
      header.put(std::size_t(280 + 16 * row + 4 * column), float(sign * value));
    };
    for (int axis = 0; axis < 3; axis++) put(axis, grid.axes.column[axis][row] * grid.spacing[axis]);
    put(3, grid.origin[row]);
    header.put(std::size_t(80 + 4 * row), float(grid.spacing[row] * 1e3));
  }
}

Header make_header(const SamplesToWrite& samples) {
  Header header;
  const bool is_vector = samples.components > 1;
  header.put<std::int32_t>(0, 348);
  const int dim[] = {is_vector ? 5 : 3,
                     samples.grid.size.x,
                     samples.grid.size.y,
                     samples.grid.size.z,
                     1,
                     samples.components,
                     1,
                     1};
  for (std::size_t axis = 0; axis < 8; axis++) header.put(40 + 2 * axis, std::int16_t(dim[axis]));
  if (is_vector) header.put<std::int16_t>(68, 1007);  // intent: a vector
  header.put(70, std::int16_t(nifti_type(samples.type)));
  header.put(72, std::int16_t(8 * byte_size(samples.type)));
  put_grid(header, samples.grid);
  header.put<float>(108, 352);
  header.put<float>(112, 1);
  header.put<char>(123, 2);  // mm
  header.put(344, std::array<char, 4>{'n', '+', '1', 0});
  return header;
}

/// Samples by component: NIfTI stores one volume per component.
std::vector<char> planes(const SamplesToWrite& samples) {
  const std::size_t size = byte_size(samples.type), components = std::size_t(samples.components),
                    count = sample_count(samples.grid);
  const auto* mixed = static_cast<const char*>(samples.data);
  std::vector<char> planar(count * components * size);
  for (std::size_t c = 0; c < components; c++)
    for (std::size_t i = 0; i < count; i++)
      std::memcpy(&planar[(c * count + i) * size], mixed + (i * components + c) * size, size);
  return planar;
}

}  // namespace

Status write_nifti(FileWriter& file, const std::filesystem::path& path, const SamplesToWrite& samples,
                   const Exec& exec) {
  const Int3 size = samples.grid.size;
  if (std::max({size.x, size.y, size.z}) > 32767)
    return Error{fmt::format("{}: {} x {} x {} samples do not fit NIfTI-1 (32767 each)", path.string(),
                             size.x, size.y, size.z)};
  const Header header = make_header(samples);
  const std::string_view head(header.bytes().data(), header.bytes().size());
  const std::vector<char> planar = samples.components > 1 ? planes(samples) : std::vector<char>{};
  const std::string_view bytes =
      planar.empty() ? samples.bytes() : std::string_view(planar.data(), planar.size());
  const auto out = [&file](std::string_view piece) { file.write(piece); };
  if (path.extension() == ".gz")
    deflate_gzip(exec, {head, bytes}, out);
  else
    out(head), out(bytes);
  return Done{};
}

}  // namespace turgor::io
