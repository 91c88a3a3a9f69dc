// Volumes with a meaning (Hounsfield units, labels, directions) from files of any format.
#include "turgor/io/ct.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "turgor/geometry/grid_difference.hpp"
#include "turgor/geometry/hounsfield.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/input_file.hpp"
#include "turgor/io/files/within_memory.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor {

namespace fs = std::filesystem;
using io::RawVolume;
using io::SampleType;

namespace {

Result<RawVolume> read_raw(const fs::path& path, int components) {
  if (Status input = io::check_input(path); !input) return input.error();
  if (io::is_dicom(path))
    return Error{fmt::format("{}: holds DICOM; expected NIfTI, NRRD or MetaImage", path.string())};
  Result<RawVolume> raw = io::read_volume_file(path);
  if (raw && raw->components != components)
    return Error{
        fmt::format("{}: {} components per sample; expected {}", path.string(), raw->components, components)};
  return raw;
}

/// Number of samples whose Hounsfield units differ from the file's values.
struct Changed {
  std::size_t no_number = 0, rounded = 0, clamped = 0;
};

std::int16_t to_hu(double value, Changed& changed) {
  if (std::isnan(value)) return changed.no_number++, kAirHu;
  const double kept = std::clamp(value, -32768.0, 32767.0), whole = std::nearbyint(kept);
  changed.clamped += kept != value;
  changed.rounded += whole != kept;
  return std::int16_t(whole);
}

std::vector<std::int16_t> hounsfield(const Exec& exec, const RawVolume& raw,
                                     std::vector<std::string>& notes) {
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  std::vector<std::int16_t> hu(raw.value_count());
  std::vector<Changed> blocks((hu.size() + kBlock - 1) / kBlock);
  visit_samples(raw, [&](const auto* stored) {
    parallel_for(exec, blocks.size(), [&](std::size_t b) {
      for (std::size_t i = b * kBlock; i < std::min(hu.size(), (b + 1) * kBlock); i++)
        hu[i] = to_hu(raw.slope * double(stored[i]) + raw.intercept, blocks[b]);
    });
  });
  Changed all;
  for (const Changed& b : blocks)
    all.no_number += b.no_number, all.rounded += b.rounded, all.clamped += b.clamped;
  const auto note = [&](std::size_t count, const std::string& what) {
    if (count > 0) notes.push_back(fmt::format("{} of {} samples {}", count, hu.size(), what));
  };
  note(all.rounded, "were rounded to integer Hounsfield units");
  note(all.no_number, fmt::format("are not numbers (NaN) and became air ({} HU)", kAirHu));
  note(all.clamped, "were outside -32768 to 32767 HU and were clamped");
  return hu;
}

/// Index of the first sample that is not an integer in 0…65535.
std::optional<std::size_t> first_without_label(const RawVolume& raw) {
  return visit_samples(raw, [&](const auto* stored) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < raw.value_count(); i++) {
      const double value = raw.slope * double(stored[i]) + raw.intercept;
      if (!(value >= 0 && value <= 65535) || value != std::floor(value)) return i;
    }
    return std::nullopt;
  });
}

Error no_label(const fs::path& path, const RawVolume& raw, std::size_t at) {
  const std::size_t nx = std::size_t(raw.grid.size.x), ny = std::size_t(raw.grid.size.y);
  const double value =
      raw.slope * visit_samples(raw, [&](const auto* stored) { return double(stored[at]); }) + raw.intercept;
  return {fmt::format("{}: sample ({}, {}, {}) is {}; expected labels: integers from 0 to 65535",
                      path.string(), at % nx, at / nx % ny, at / nx / ny, value)};
}

Result<CtFile> read_any_ct(const Exec& exec, const fs::path& path, const ReadOptions& options) {
  std::error_code failed;
  if (fs::is_directory(path, failed)) return io::read_dicom(exec, path, options);
  if (Status input = io::check_input(path); !input) return input.error();
  if (io::is_dicom(path)) return io::read_dicom(exec, path, options);
  if (!options.series.empty() || options.straighten)
    return Error{
        fmt::format("{}: only DICOM has series and tilted slices; expected no such option", path.string())};
  const Result<RawVolume> raw = read_raw(path, 1);
  if (!raw) return raw.error();
  CtFile file;
  if (!raw->missing.empty())
    file.notes.push_back(fmt::format("the file states no {}; check its size, left and right", raw->missing));
  file.format = name(raw->format);
  file.ct = right_handed(CtVolume{raw->grid, hounsfield(exec, *raw, file.notes)});
  if (std::string doubt = doubt_of_hounsfield_units(file.ct); !doubt.empty()) file.notes.push_back(doubt);
  if (options.progress) options.progress(1);
  return file;
}

Result<io::VolumeHeader> header_of_slices(const fs::path& path) {
  if (Status input = io::check_input(path); !input) return input.error();
  const std::string expected = "expected an uncompressed .nii, .nrrd, .nhdr, .mha or .mhd";
  std::error_code failed;
  if (fs::is_directory(path, failed) || io::is_dicom(path))
    return Error{
        fmt::format("{}: holds DICOM, whose slices cannot be read separately; {}", path.string(), expected)};
  Result<io::VolumeHeader> header = io::read_volume_header(path);
  if (!header) return header;
  if (Status grid = io::check_grid(path, header->grid); !grid) return grid.error();
  if (header->components != 1)
    return Error{fmt::format("{}: {} components per sample; expected 1", path.string(), header->components)};
  if (header->is_packed)
    return Error{
        fmt::format("{}: compressed, so that slices cannot be read separately; {}", path.string(), expected)};
  return header;
}

}  // namespace

Result<CtFile> read_ct(const Exec& exec, const fs::path& path, const ReadOptions& options) {
  return io::within_memory(path, [&] { return read_any_ct(exec, path, options); });
}

Result<Grid> read_ct_grid(const fs::path& path) {
  const Result<io::VolumeHeader> header = header_of_slices(path);
  if (!header) return header.error();
  if (determinant(header->grid.axes) > 0) return header->grid;
  return reordered(header->grid, AxisOrder{.flip = {true, false, false}});
}

Result<std::vector<std::int16_t>> read_ct_slices(const Exec& exec, const fs::path& path, int begin, int end) {
  const Result<io::VolumeHeader> header = header_of_slices(path);
  if (!header) return header.error();
  const Result<RawVolume> raw = io::read_volume_slices(path, *header, begin, end);
  if (!raw) return raw.error();
  std::vector<std::string> notes;
  return right_handed(CtVolume{raw->grid, hounsfield(exec, *raw, notes)}).samples;
}

std::string list_dicom_series(const Exec& exec, const fs::path& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) return {};
  const Result<io::DicomFolder> found = io::scan_dicom(exec, folder, true, {});
  return found && !found->slices.empty() ? io::list_series(found->slices) : std::string{};
}

LabelNames read_label_names(const fs::path& path) {
  if (!io::check_input(path)) return {};
  return io::is_dicom(path) ? io::read_segment_names(path) : io::read_header_names(path);
}

Result<LabelFile> read_labels_of(const fs::path& path, const Grid& ct) {
  Result<LabelFile> read = read_labels(path);
  if (!read) return read;
  std::optional<LabelVolume> on_ct =
      read->is_cropped ? part_on_grid(read->labels, ct) : on_grid(read->labels, ct);
  if (!on_ct) {
    const Grid& grid = read->labels.grid;
    return Error{fmt::format("{}: its grid differs from the CT's: {}; expected a segmentation of this CT",
                             path.string(),
                             read->is_cropped ? box_difference(grid, ct) : grid_difference(grid, ct))};
  }
  read->labels = std::move(*on_ct);
  return read;
}

namespace {

Result<LabelFile> read_any_labels(const fs::path& path) {
  if (Status input = io::check_input(path); !input) return input.error();
  if (io::is_dicom(path)) return io::read_segmentation(path);
  const Result<RawVolume> raw = read_raw(path, 1);
  if (!raw) return raw.error();
  if (const auto at = first_without_label(*raw)) return no_label(path, *raw, *at);
  LabelVolume labels{raw->grid, std::vector<std::uint16_t>(raw->value_count())};
  visit_samples(*raw, [&](const auto* stored) {
    std::transform(stored, stored + labels.samples.size(), labels.samples.begin(),
                   [&](auto v) { return std::uint16_t(raw->slope * double(v) + raw->intercept); });
  });
  LabelFile file{right_handed(std::move(labels)), raw->label_names, !raw->label_names.empty()};
  if (!file.has_names) file.names = usual_names();
  return file;
}

Result<VectorVolume> read_any_vectors(const fs::path& path) {
  const Result<RawVolume> raw = read_raw(path, 3);
  if (!raw) return raw.error();
  VectorVolume vectors{raw->grid, std::vector<Vec3>(raw->value_count() / 3)};
  visit_samples(*raw, [&](const auto* stored) {
    const auto value = [&](std::size_t at) { return Real(raw->slope * double(stored[at]) + raw->intercept); };
    for (std::size_t i = 0; i < vectors.samples.size(); i++)
      vectors.samples[i] = {value(3 * i), value(3 * i + 1), value(3 * i + 2)};
  });
  return right_handed(std::move(vectors));
}

}  // namespace

Result<LabelFile> read_labels(const fs::path& path) {
  return io::within_memory(path, [&] { return read_any_labels(path); });
}

Result<VectorVolume> read_vectors(const fs::path& path) {
  return io::within_memory(path, [&] { return read_any_vectors(path); });
}

Status write_ct(const fs::path& path, const CtVolume& ct, const Exec& exec) {
  return io::write_volume_file(path, {ct.grid, SampleType::kInt16, 1, ct.samples.data()}, exec);
}

Status write_labels(const fs::path& path, const LabelVolume& labels) {
  return io::write_volume_file(path, {labels.grid, SampleType::kUint16, 1, labels.samples.data()});
}

Status write_scalars(const fs::path& path, const ScalarVolume& volume) {
  return io::write_volume_file(path, {volume.grid, SampleType::kFloat, 1, volume.samples.data()});
}

Status write_displacement(const fs::path& path, const VectorVolume& displacement) {
  std::vector<Vec3> mm(displacement.samples.size());
  std::transform(displacement.samples.begin(), displacement.samples.end(), mm.begin(),
                 [](Vec3 v) { return v * 1000.0f; });
  return io::write_volume_file(path, {displacement.grid, SampleType::kFloat, 3, mm.data()});
}

}  // namespace turgor
