// Selects the files of a folder that form one volume, and finds its grid. Errors name file and position for
// all that would give a wrong volume: gantry tilt, gaps, duplicate positions, mixed directions or sizes.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"
#include "turgor/io/dicom/dicom.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

using Slices = std::vector<DicomSlice>;

/// Slices by series, in the order of their first files.
std::vector<Slices> group_series(Slices slices) {
  std::map<std::string, Slices> by_uid;
  for (DicomSlice& s : slices) by_uid[s.series].push_back(std::move(s));
  std::vector<Slices> series;
  for (auto& [uid, group] : by_uid) series.push_back(std::move(group));
  std::sort(series.begin(), series.end(),
            [](const Slices& a, const Slices& b) { return a.front().file < b.front().file; });
  return series;
}

std::string list_groups(const std::vector<Slices>& series) {
  std::string list;
  for (std::size_t i = 0; i < series.size(); i++) {
    const DicomSlice& first = series[i].front();
    list += fmt::format("\n  {}: {} {} of {} x {}, {}, \"{}\", {}", i + 1, series[i].size(),
                        series[i].size() == 1 ? "slice" : "slices", first.columns, first.rows,
                        first.modality.empty() ? "no modality" : first.modality, first.description,
                        first.series.empty() ? "(empty SeriesInstanceUID)" : first.series);
  }
  return list;
}

std::string name_of(const DicomSlice& slice) {
  const std::string file = slice.file.filename().string();
  return slice.frame > 0 ? fmt::format("{}, frame {}", file, slice.frame) : file;
}

/// Removes localizers that share a series with its slices.
void drop_localizers(DicomVolume& volume) {
  const auto is_localizer = [](const DicomSlice& s) {
    return s.image_type.find("LOCALIZER") != std::string::npos;
  };
  const auto count = std::size_t(std::count_if(volume.slices.begin(), volume.slices.end(), is_localizer));
  if (count == 0 || count == volume.slices.size()) return;
  std::erase_if(volume.slices, is_localizer);
  volume.notes.push_back(fmt::format("{} localizer images of the series were ignored", count));
}

/// Checks sizes before memory is allocated: the file must be large enough for the header's size, and
/// compressed pixels must agree with it.
Status check_size(const DicomSlice& s) {
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;
  if (std::int64_t(s.rows) * s.columns > kMostPixels)
    return Error{fmt::format("{}: {} x {} pixels; expected a slice of a CT, of at most {} pixels",
                             s.file.string(), s.columns, s.rows, kMostPixels)};
  const auto promised =
      std::uint64_t(s.rows) * std::uint64_t(s.columns) * std::uint64_t(s.bits_allocated) / 8;
  if (s.is_compressed && s.pixel_length > 4 * promised + 65536)
    return Error{fmt::format("{}: corrupt: {} bytes of compressed pixels for {} x {} of {} bits",
                             s.file.string(), s.pixel_length, s.columns, s.rows, s.bits_allocated)};
  if (s.pixel_length * (s.is_compressed ? 1000 : 1) >= promised)
    return s.is_compressed ? check_frame(s) : Status(Done{});
  return Error{fmt::format("{}: truncated or corrupt: {} bytes of pixels cannot hold {} x {} of {} bits",
                           s.file.string(), s.pixel_length, s.columns, s.rows, s.bits_allocated)};
}

Status check_slice(const DicomSlice& s) {
  const std::string file = s.file.string();
  if (s.modality != "CT") return Error{fmt::format("{}: Modality is \"{}\"; expected CT", file, s.modality)};
  if (s.frames < 1)
    return Error{fmt::format("{}: NumberOfFrames (0028,0008) is no whole number from 1", file)};
  if (s.frames != 1)
    return Error{
        fmt::format("{}: an image of {} frames without positions in its header; expected "
                    "an enhanced CT image with functional groups, or one file per slice",
                    file, s.frames)};
  if (s.samples_per_pixel != 1 || !s.photometric.starts_with("MONOCHROME"))
    return Error{fmt::format("{}: a color image ({}, {} samples per pixel); expected MONOCHROME2", file,
                             s.photometric, s.samples_per_pixel)};
  if ((s.bits_allocated != 8 && s.bits_allocated != 16 && s.bits_allocated != 32) || s.bits_stored < 1 ||
      s.bits_stored > s.bits_allocated)
    return Error{fmt::format("{}: {} bits stored in {}; expected at most 8, 16 or 32", file, s.bits_stored,
                             s.bits_allocated)};
  if (s.high_bit != s.bits_stored - 1)
    return Error{
        fmt::format("{}: HighBit (0028,0102) is {} with {} bits stored; expected {}: values that do not "
                    "start at the lowest bit are not supported",
                    file, s.high_bit, s.bits_stored, s.bits_stored - 1)};
  if (!s.position)
    return Error{fmt::format("{}: no ImagePositionPatient (0020,0032): the slice has no position", file)};
  if (std::abs(norm(s.row_direction) - 1) > 0.01 || std::abs(norm(s.column_direction) - 1) > 0.01 ||
      std::abs(dot(s.row_direction, s.column_direction)) > 1e-3)
    return Error{fmt::format(
        "{}: ImageOrientationPatient (0020,0037) is missing or not two orthogonal directions", file)};
  if (!(s.row_spacing > 0) || !(s.column_spacing > 0))
    return Error{fmt::format("{}: PixelSpacing (0028,0030) is missing or not positive", file)};
  return Done{};
}

Status check_alike(const DicomSlice& first, const DicomSlice& s) {
  if (s.rows != first.rows || s.columns != first.columns)
    return Error{fmt::format("{}: {} x {} pixels; the series' first file, {}, has {} x {}", s.file.string(),
                             s.columns, s.rows, name_of(first), first.columns, first.rows)};
  const double turned = std::max(norm(s.row_direction - first.row_direction),
                                 norm(s.column_direction - first.column_direction));
  if (turned > 1e-3)
    return Error{
        fmt::format("{}: orientation differs by {:.2f} degrees from that of {}; expected parallel slices",
                    s.file.string(), turned * 180 / M_PI, name_of(first))};
  if (std::abs(s.row_spacing / first.row_spacing - 1) > 1e-3 ||
      std::abs(s.column_spacing / first.column_spacing - 1) > 1e-3)
    return Error{fmt::format("{}: pixels of {} x {} mm; those of {} are {} x {} mm", s.file.string(),
                             s.column_spacing, s.row_spacing, name_of(first), first.column_spacing,
                             first.row_spacing)};
  return Done{};
}

Mat3d slice_axes(const DicomSlice& slice) {
  const Vec3d i = normalized(slice.row_direction);
  const Vec3d k = normalized(cross(i, slice.column_direction));
  return {{i, cross(k, i), k}};
}

/// In-plane offset of a slice from the first one [mm].
Vec3d in_plane_offset(const Slices& slices, const DicomSlice& s, Vec3d normal) {
  const Vec3d displacement = *s.position - *slices.front().position;
  return displacement - normal * dot(displacement, normal);
}

std::string tilt_text(const Slices& slices, Vec3d normal) {
  const double up = dot(*slices.back().position - *slices.front().position, normal);
  const double angle = std::atan2(norm(in_plane_offset(slices, slices.back(), normal)), up) * 180 / M_PI;
  return fmt::format("gantry tilt of {:.1f} degrees", angle);
}

/// Refusal of a stack that is not straight. It names the slice that is shifted farthest in its plane.
Error not_straight(const fs::path& folder, const Slices& slices, Vec3d normal, bool is_tilted) {
  const auto shift = [&](const DicomSlice& s) { return norm(in_plane_offset(slices, s, normal)); };
  const DicomSlice& farthest =
      *std::max_element(slices.begin(), slices.end(),
                        [&](const DicomSlice& a, const DicomSlice& b) { return shift(a) < shift(b); });
  return {fmt::format(
      "{}: {}slice {} is shifted in its plane by {:.2f} mm from {}; expected a straight stack{}",
      folder.string(), is_tilted ? tilt_text(slices, normal) + ": " : "", name_of(farthest), shift(farthest),
      name_of(slices.front()), is_tilted ? " (turgor import --straighten resamples them)" : "")};
}

/// Constant in-plane shift between consecutive slices due to a tilted gantry [mm]; 0 for a straight stack.
Result<Vec3d> slice_shift(const fs::path& folder, const Slices& slices, Vec3d normal, bool may_lean) {
  const Vec3d whole = in_plane_offset(slices, slices.back(), normal);
  const double steps = std::max(1.0, double(slices.size()) - 1);
  bool leans = false;
  for (std::size_t i = 0; i < slices.size(); i++) {
    const DicomSlice& s = slices[i];
    const double near = 0.1 * std::min(s.row_spacing, s.column_spacing);
    const Vec3d shift = in_plane_offset(slices, s, normal);
    if (norm(shift) <= near && norm(whole) <= near) continue;
    leans = true;
    if (!may_lean) return not_straight(folder, slices, normal, norm(whole) > near);
    if (norm(shift - whole * (double(i) / steps)) > near)
      return Error{
          fmt::format("{}: slice {} is {:.2f} mm off the line from the first slice to the last; "
                      "expected a constant shift, as of a tilted gantry",
                      folder.string(), name_of(s), norm(shift - whole * (double(i) / steps)))};
  }
  return leans ? whole / steps : Vec3d{};
}

/// Expected distance of slices: the smallest gap if all others are multiples of it (missing slices);
/// otherwise the median.
double expected_gap(const std::vector<double>& gaps) {
  const double smallest = *std::min_element(gaps.begin(), gaps.end());
  const auto is_multiple = [&](double gap) {
    return std::abs(gap / smallest - std::round(gap / smallest)) < 0.05;
  };
  return smallest > 0 && std::all_of(gaps.begin(), gaps.end(), is_multiple) ? smallest : median(gaps);
}

/// Distance of slices, which must be constant [mm].
Result<double> even_spacing(const fs::path& folder, const Slices& slices, Vec3d normal) {
  std::vector<double> offset, gaps;
  for (const DicomSlice& s : slices) offset.push_back(dot(*s.position, normal));
  for (std::size_t i = 1; i < offset.size(); i++) gaps.push_back(offset[i] - offset[i - 1]);
  const double usual = median(gaps);
  const auto at = [&](std::size_t i) {
    return fmt::format("{} (at {:.2f} mm along the normal)", name_of(slices[i]), offset[i]);
  };
  for (std::size_t i = 0; i < gaps.size(); i++)
    if (gaps[i] < 0.01 * usual || gaps[i] < 1e-6)
      return Error{fmt::format(
          "{}: {} and {} lie at the same position; expected one slice per position (several phases or "
          "reconstructions in one series?)",
          folder.string(), at(i), at(i + 1))};
  const double expected = expected_gap(gaps);
  const long missing = std::lround((offset.back() - offset.front()) / expected) - long(gaps.size());
  for (std::size_t i = 0; i < gaps.size(); i++) {
    if (std::abs(gaps[i] - expected) <= std::max(0.02 * expected, 0.05)) continue;
    const bool is_whole =
        std::abs(gaps[i] / expected - std::round(gaps[i] / expected)) < 0.1 && gaps[i] > 1.5 * expected;
    return Error{fmt::format(
        "{}: {}, first between {} and {}: a gap of {:.2f} mm, expected {:.2f} mm", folder.string(),
        is_whole ? fmt::format("missing slices: {} of {}", missing, missing + long(slices.size()))
                 : std::string("uneven slice distance"),
        at(i), at(i + 1), gaps[i], expected)};
  }
  return (offset.back() - offset.front()) / double(gaps.size());
}

Result<double> slice_spacing(const fs::path& folder, const Slices& slices, Vec3d normal) {
  if (slices.size() > 1) return even_spacing(folder, slices, normal);
  if (slices[0].thickness > 0) return slices[0].thickness;
  return Error{fmt::format("{}: a single slice without SliceThickness (0018,0050): no volume",
                           slices[0].file.string())};
}

}  // namespace

std::string list_series(const Slices& slices) { return list_groups(group_series(slices)); }

Result<Slices> choose_series(const fs::path& folder, Slices slices, const std::string& requested) {
  std::vector<Slices> series = group_series(std::move(slices));
  if (requested.empty() && series.size() == 1) return std::move(series[0]);
  if (requested.empty())
    return Error{fmt::format("{}: holds {} series; choose one with --series NUMBER or --series UID:{}",
                             folder.string(), series.size(), list_groups(series))};
  for (std::size_t i = 0; i < series.size(); i++)
    if (requested == series[i].front().series || requested == std::to_string(i + 1))
      return std::move(series[i]);
  return Error{
      fmt::format("{}: has no series \"{}\"; there are:{}", folder.string(), requested, list_groups(series))};
}

Result<DicomVolume> stack_slices(const fs::path& folder, Slices slices, bool may_lean) {
  DicomVolume volume{std::move(slices), {}, {}, {}};
  drop_localizers(volume);
  for (const DicomSlice& s : volume.slices) {
    if (Status alone = check_slice(s); !alone) return alone.error();
    if (Status size = check_size(s); !size) return size.error();
    if (Status alike = check_alike(volume.slices.front(), s); !alike) return alike.error();
  }
  const Mat3d axes = slice_axes(volume.slices.front());
  const Vec3d normal = axes.column[2];
  std::stable_sort(volume.slices.begin(), volume.slices.end(), [&](const auto& a, const auto& b) {
    return dot(*a.position, normal) < dot(*b.position, normal);
  });
  const Result<double> spacing = slice_spacing(folder, volume.slices, normal);
  if (!spacing) return spacing.error();
  const Result<Vec3d> shift = slice_shift(folder, volume.slices, normal, may_lean);
  if (!shift) return shift.error();
  if (norm(*shift) > 0)
    volume.notes.push_back(tilt_text(volume.slices, normal) +
                           ": its slices were resampled to a straight grid, within each of them");
  const DicomSlice& first = volume.slices.front();
  volume.grid = {.size = {first.columns, first.rows, int(volume.slices.size())},
                 .spacing = Vec3d{first.column_spacing, first.row_spacing, *spacing} * 1e-3,
                 .origin = *first.position * 1e-3,
                 .axes = axes};
  volume.shift = *shift * 1e-3;
  return volume;
}

}  // namespace turgor::io
