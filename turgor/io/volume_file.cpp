#include "turgor/io/volume_file.hpp"

#include <cmath>
#include <new>

#include <fmt/format.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

using Component = itk::CommonEnums::IOComponent;

itk::ImageIOBase::Pointer make_image_io(VolumeFormat format) {
  if (format == VolumeFormat::kNrrd) return itk::NrrdImageIO::New().GetPointer();
  return itk::MetaImageIO::New().GetPointer();
}

constexpr std::pair<Component, SampleType> kComponents[] = {
    {Component::CHAR, SampleType::kInt8},      {Component::UCHAR, SampleType::kUint8},
    {Component::SHORT, SampleType::kInt16},    {Component::USHORT, SampleType::kUint16},
    {Component::INT, SampleType::kInt32},      {Component::UINT, SampleType::kUint32},
    {Component::LONG, SampleType::kInt64},     {Component::ULONG, SampleType::kUint64},
    {Component::LONGLONG, SampleType::kInt64}, {Component::ULONGLONG, SampleType::kUint64},
    {Component::FLOAT, SampleType::kFloat},    {Component::DOUBLE, SampleType::kDouble}};
static_assert(sizeof(long) == 8);

Result<SampleType> sample_type(const fs::path& path, Component component) {
  for (const auto& [known, type] : kComponents)
    if (known == component) return type;
  return Error{fmt::format("{}: samples of an unknown type; expected whole or real numbers", path.string())};
}

Grid itk_grid(const itk::ImageIOBase& io, const VolumeHeader& header) {
  Grid grid;
  for (unsigned axis = 0; axis < 3; axis++) {
    const int a = int(axis);
    grid.size[a] = int(header.size[axis]);
    grid.spacing[a] = io.GetSpacing(axis) * 1e-3;
    grid.origin[a] = io.GetOrigin(axis) * 1e-3;
    const std::vector<double> direction = io.GetDirection(axis);
    grid.axes.column[a] = normalized(Vec3d{direction[0], direction[1], direction[2]});
  }
  return grid;
}

Status check_grid(const fs::path& path, const Grid& grid) {
  for (int axis = 0; axis < 3; axis++) {
    const double spacing = grid.spacing[axis], origin = grid.origin[axis];
    if (!(spacing > 0) || !std::isfinite(spacing))
      return Error{fmt::format("{}: spacing along axis {} is {} mm; expected a positive number",
                               path.string(), axis, spacing * 1e3)};
    if (!std::isfinite(origin)) return Error{fmt::format("{}: the origin is not finite", path.string())};
    const Vec3d a = grid.axes.column[axis], b = grid.axes.column[(axis + 1) % 3];
    const double cosine = dot(a, b);
    if (!(std::abs(cosine) < 1e-3) || !(std::abs(norm(a) - 1) < 1e-3))
      return Error{fmt::format(
          "{}: axes {} and {} meet at {:.2f} degrees; expected right angles (resample the volume to a "
          "grid of right angles first)",
          path.string(), axis, (axis + 1) % 3, std::acos(cosine) * 180 / M_PI)};
  }
  return Done{};
}

/// Runs body and turns what ITK throws into an error.
template <class Body>
auto guarded(const fs::path& path, const char* what, const Body& body) -> decltype(body()) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return Error{fmt::format("{}: cannot be {}: not enough memory", path.string(), what)};
  } catch (const std::exception&) {  // what ITK says speaks of its sources
    return Error{
        fmt::format("{}: cannot be {}: the file or its folder is damaged, full, or not as its header says",
                    path.string(), what)};
  }
}

Result<RawVolume> read_samples(const fs::path& path, const VolumeHeader& header) {
  const itk::ImageIOBase::Pointer io = make_image_io(header.format);
  io->SetFileName(path.string());
  io->ReadImageInformation();
  if (io->GetNumberOfDimensions() < 3)
    return Error{fmt::format("{}: fewer than 3 dimensions", path.string())};
  itk::ImageIORegion region(io->GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); axis++) {
    const std::int64_t expected = axis < 3 ? header.size[axis] : 1;
    if (std::int64_t(io->GetDimensions(axis)) != expected)
      return Error{fmt::format("{}: corrupt: the header can be read in two ways", path.string())};
    region.SetSize(axis, io->GetDimensions(axis));
  }
  io->SetIORegion(region);
  const Result<SampleType> type = sample_type(path, io->GetComponentType());
  if (!type) return type.error();
  RawVolume raw{header.format, itk_grid(*io, header), *type, int(io->GetNumberOfComponents()), 1, 0, {}, {}};
  if (raw.components != header.components)
    return Error{fmt::format("{}: corrupt: {} components, expected {}", path.string(), raw.components,
                             header.components)};
  raw.bytes.resize(sample_count(raw.grid) * std::size_t(raw.components) * byte_size(raw.type));
  io->Read(raw.bytes.data());
  return raw;
}

}  // namespace

Result<RawVolume> read_volume_file(const fs::path& path) {
  const Result<VolumeHeader> header = read_volume_header(path);
  if (!header) return header.error();
  Result<RawVolume> raw = guarded(path, "read", [&] {
    return header->format == VolumeFormat::kNifti ? read_nifti_samples(path, *header)
                                                  : read_samples(path, *header);
  });
  if (!raw) return raw;
  raw->label_names = header->label_names;
  if (Status placed = check_grid(path, raw->grid); !placed) return placed.error();
  return raw;
}

}  // namespace turgor::io
