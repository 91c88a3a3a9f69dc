// DICOM segmentations: one bit or a fraction per sample, segment by segment, for slices that contain the
// segment. [DICOM PS3.3, A.51, C.8.20]
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turgor/geometry/reorient.hpp"
#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/header_text.hpp"
#include "turgor/io/files/input_file.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";

struct Segmentation {
  DicomElements elements;
  DicomSlice image;                // common to all frames
  std::vector<DicomSlice> frames;  // positions
  std::vector<int> segment;        // of each frame
  bool is_fractional = false;
  int most = 1;  // value of a sample that is entirely in the segment
};

LabelNames names_of(const DicomElements& set) {
  LabelNames names;
  for (const DicomValues& segment : set.segments) {
    const auto number = segment.find(0x00620004), label = segment.find(0x00620005);
    if (number == segment.end() || label == segment.end()) continue;
    const int n = short_integer(number->second, false, set.is_big_endian).value_or(0);
    const std::string name = trimmed(std::string_view(label->second).substr(0, label->second.find('\0')));
    if (n > 0 && !name.empty()) names.emplace(n, name);
  }
  return names;
}

/// Segment of a frame, possibly from the shared values; 0 if it is missing.
int segment_of(const DicomElements& set, const DicomValues& frame) {
  for (const DicomValues* values : {&frame, set.shared.empty() ? &frame : &set.shared.front()})
    if (const auto found = values->find(0x0062000b); found != values->end())
      return short_integer(found->second, false, set.is_big_endian).value_or(0);
  return 0;
}

Error refusal(const fs::path& file, const std::string& what) {
  return {fmt::format("{}: {}", file.string(), what)};
}

/// Refuses files that are not a supported DICOM segmentation. Compressed bits are not supported, except in
/// files that are deflated as a whole. [PS3.5, 8.2, A.4, A.5]
Status check_kind(const fs::path& file, Segmentation& seg) {
  const DicomElements& set = seg.elements;
  const DicomSlice& image = seg.image;
  const std::string kind = trimmed(set.value(0x0008, 0x0016).substr(0, kSegmentation.size()));
  const std::string type = trimmed(set.value(0x0062, 0x0001));
  if (kind != kSegmentation)
    return refusal(
        file,
        "a DICOM file that is not a segmentation; expected labels: a DICOM SEG, NIfTI, NRRD or MetaImage");
  seg.is_fractional = type == "FRACTIONAL";
  if ((type != "BINARY" || image.bits_allocated != 1) && (!seg.is_fractional || image.bits_allocated != 8))
    return refusal(file,
                   fmt::format("a segmentation of type {}, {} bits per sample; expected BINARY, 1 bit, or "
                               "FRACTIONAL, 8 bits",
                               type, image.bits_allocated));
  if (image.is_big_endian) return refusal(file, "a big-endian segmentation; expected a little-endian one");
  if (!seg.is_fractional && image.is_compressed)
    return refusal(
        file,
        "compressed bits; expected BINARY uncompressed or deflated (only FRACTIONAL may be compressed)");
  if (!seg.is_fractional) return Done{};
  seg.most = short_integer(set.value(0x0062, 0x000e), false, false).value_or(0);
  if (seg.most >= 1 && seg.most <= 255) return Done{};
  return refusal(file, fmt::format("MaximumFractionalValue is {}, expected 1 to 255", seg.most));
}

/// SpacingBetweenSlices, shared by all frames [mm].
std::optional<double> shared_spacing(const DicomElements& set) {
  if (set.shared.empty()) return std::nullopt;
  const auto said = set.shared.front().find(0x00180088);
  if (said == set.shared.front().end()) return std::nullopt;
  const std::vector<double> number = decimal_numbers(said->second);
  return number.size() == 1 ? std::optional(number[0]) : std::nullopt;
}

/// Distances of neighboring planes, ascending [mm]. Several segments have frames in one plane, at positions
/// that may be rounded differently.
std::vector<double> gaps_of(const std::vector<double>& sorted, const DicomSlice& frame) {
  const double same_plane = 0.02 * std::min(frame.row_spacing, frame.column_spacing);
  std::vector<double> gaps;
  for (std::size_t n = 1; n < sorted.size(); n++)
    if (const double gap = sorted[n] - sorted[n - 1]; gap > same_plane) gaps.push_back(gap);
  std::sort(gaps.begin(), gaps.end());
  return gaps;
}

/// Mean distance of planes with these gaps, ascending, where some planes have no frame [mm]. `rough` only
/// counts the planes of the smallest gap; 0 if it contradicts that gap.
double mean_distance(const std::vector<double>& gaps, double rough) {
  const double least = gaps.front() / rough;
  if (!(rough > 0) || least < 0.5 || !(std::abs(least - std::round(least)) < 0.05)) return 0;
  double length = 0, planes = 0;
  for (const double gap : gaps) {
    planes += std::round(gap / (planes > 0 ? length / planes : rough));
    length += gap;
  }
  return length / planes;
}

/// Distance of the planes through `sorted` positions [mm]. The stated distance is often rounded, and that of
/// another series in some files: it decides only how many planes are between frames. 0 if nothing is known.
double plane_distance(const DicomElements& set, const std::vector<double>& sorted, const DicomSlice& frame) {
  const double stated = shared_spacing(set).value_or(0);
  const std::vector<double> gaps = gaps_of(sorted, frame);
  if (gaps.empty()) return stated > 0 ? stated : frame.thickness;
  const double mean = mean_distance(gaps, stated);
  return mean > 0 ? mean : mean_distance(gaps, gaps.front());
}

/// Grid through all frames, from their positions. Frames are on equidistant planes, some of which may be
/// empty.
Result<Grid> grid_of(const fs::path& file, const Segmentation& seg) {
  const DicomSlice& first = seg.frames.front();
  const Vec3d i = normalized(first.row_direction), k = normalized(cross(i, first.column_direction));
  std::vector<double> offsets;
  for (const DicomSlice& s : seg.frames) {
    if (!s.position || std::abs(norm(s.row_direction) - 1) > 0.01 ||
        norm(s.row_direction - first.row_direction) > 1e-3 ||
        norm(s.column_direction - first.column_direction) > 1e-3 || !(s.row_spacing > 0) ||
        !(s.column_spacing > 0))
      return refusal(file, fmt::format("frame {} has no position, or is not parallel to the first", s.frame));
    offsets.push_back(dot(*s.position, k));
  }
  std::sort(offsets.begin(), offsets.end());
  const double spacing = plane_distance(seg.elements, offsets, first);
  if (!(spacing > 0))
    return refusal(
        file, "a single plane of frames with neither a positive SpacingBetweenSlices nor a SliceThickness");
  const double count = (offsets.back() - offsets.front()) / spacing + 1;
  for (const double offset : offsets) {
    const double n = (offset - offsets.front()) / spacing;
    if (!(std::abs(n - std::round(n)) < 0.05))
      return refusal(file,
                     fmt::format("a frame is {:.3f} mm above the first; expected a multiple of {:.3f} mm",
                                 offset - offsets.front(), spacing));
  }
  const auto lowest = std::min_element(
      seg.frames.begin(), seg.frames.end(),
      [&](const auto& a, const auto& b) { return dot(*a.position, k) < dot(*b.position, k); });
  if (!(count * double(first.rows) * double(first.columns) < double(std::int64_t{1} << 33)))
    return refusal(file, "more samples than the largest volume of 2^33");
  return Grid{.size = {first.columns, first.rows, int(std::lround(count))},
              .spacing = Vec3d{first.column_spacing, first.row_spacing, spacing} * 1e-3,
              .origin = *lowest->position * 1e-3,
              .axes = {{i, cross(k, i), k}}};
}

Result<Segmentation> read_frames(const fs::path& file) {
  if (Status input = check_input(file); !input) return input.error();
  const DicomFile header = read_dicom_header(file);
  if (!header.slice) return refusal(file, header.problem + "; expected a DICOM segmentation");
  Segmentation seg{.elements = {}, .image = *header.slice, .frames = {}, .segment = {}};
  FileWindow window(file);
  if (const Status found = find_elements(window, seg.elements); !found)
    return refusal(file, found.error().message);
  if (const Status kind = check_kind(file, seg); !kind) return kind.error();
  if (seg.image.frames < 1) return refusal(file, "NumberOfFrames (0028,0008) is no whole number from 1");
  seg.frames = frames_of(seg.image, seg.elements);
  if (seg.frames.empty()) return refusal(file, "its header has no positions of its frames");
  for (const DicomValues& frame : seg.elements.frames) {
    seg.segment.push_back(segment_of(seg.elements, frame));
    if (seg.segment.back() < 1)
      return refusal(file, fmt::format("frame {} has no segment number", seg.segment.size()));
  }
  return seg;
}

/// Stored pixels of all frames; at most `byte_count` bytes.
std::string plain_bytes(const DicomSlice& image, std::size_t byte_count) {
  std::optional<InflatedStream> inflated;
  if (image.is_deflated) inflated.emplace(deflated_dataset(image.file, image.dataset_offset));
  return stored_bytes(image, inflated ? &*inflated : nullptr, byte_count);
}

/// Samples of all frames, one byte each.
Result<std::string> decoded_bytes(const Segmentation& seg, std::size_t area) {
  std::vector<std::int16_t> values(area * seg.frames.size());
  std::vector<const DicomSlice*> slices;
  std::vector<std::span<std::int16_t>> samples;
  for (std::size_t f = 0; f < seg.frames.size(); f++) {
    if (const Status size = check_frame(seg.frames[f]); !size) return size.error();
    slices.push_back(&seg.frames[f]);
    samples.push_back(std::span(values).subspan(f * area, area));
  }
  const Result<ChangedSamples> decoded = decode_dicom_samples(Exec(), slices, samples, {});
  if (!decoded) return decoded.error();
  return std::string(values.begin(), values.end());
}

/// Samples of all frames: bits without gaps, lowest of each byte first, or bytes.
Result<std::string> bytes_of_frames(const fs::path& file, const Segmentation& seg, std::size_t area) {
  if (seg.image.is_compressed) return decoded_bytes(seg, area);
  const std::size_t samples = area * seg.frames.size(),
                    byte_count = seg.is_fractional ? samples : (samples + 7) / 8;
  if (seg.image.pixel_length >= byte_count)
    if (std::string bytes = plain_bytes(seg.image, byte_count); bytes.size() == byte_count) return bytes;
  return refusal(
      file,
      fmt::format("truncated or corrupt: {} bytes of pixels, expected {} ({} frames of {} x {})",
                  seg.image.pixel_length, byte_count, seg.frames.size(), seg.image.columns, seg.image.rows));
}

Error overlap(const fs::path& file, const Grid& grid, int one, int other, std::size_t sample) {
  const auto columns = std::size_t(grid.size.x), area = columns * std::size_t(grid.size.y);
  return refusal(file,
                 fmt::format("segments {} and {} overlap at sample ({}, {}, {}); expected one label per "
                             "sample: export the segments as one label map",
                             one, other, sample % area % columns, sample % area / columns, sample / area));
}

/// Fractions: a sample belongs to the segment with the largest fraction, if that is at least half.
Status fill_labels(const fs::path& file, const Segmentation& seg, const std::string& bytes,
                   LabelVolume& labels) {
  const std::size_t area = std::size_t(labels.grid.size.x) * std::size_t(labels.grid.size.y);
  std::vector<std::uint8_t> taken(seg.is_fractional ? labels.samples.size() : 0);
  for (std::size_t f = 0; f < seg.frames.size(); f++) {
    const auto k = std::size_t(std::lround(index_at(labels.grid, *seg.frames[f].position * 1e-3).z));
    for (std::size_t n = 0; n < area; n++) {
      const std::size_t at = f * area + n;
      std::uint16_t& label = labels.samples[k * area + n];
      if (seg.is_fractional) {
        const auto share = std::uint8_t(bytes[at]);
        if (2 * share < seg.most || share <= taken[k * area + n]) continue;
        taken[k * area + n] = share;
      } else if (!(bytes[at / 8] >> (at % 8) & 1)) {
        continue;
      } else if (label != 0 && label != seg.segment[f]) {
        return overlap(file, labels.grid, label, seg.segment[f], k * area + n);
      }
      label = std::uint16_t(seg.segment[f]);
    }
  }
  return Done{};
}

/// Checks that frames are stacked without shift, like the samples of a grid.
Status check_straight(const fs::path& file, const Segmentation& seg, const Grid& grid) {
  for (const DicomSlice& s : seg.frames) {
    const Vec3d at = index_at(grid, *s.position * 1e-3);
    if (std::abs(at.x) > 0.1 || std::abs(at.y) > 0.1)
      return refusal(file, fmt::format("frame {} is shifted in its plane from the first", s.frame));
  }
  return Done{};
}

}  // namespace

LabelNames read_segment_names(const fs::path& file) {
  DicomElements set;
  FileWindow window(file);
  return find_elements(window, set) ? names_of(set) : LabelNames{};
}

Result<LabelFile> read_segmentation(const fs::path& file) {
  const Result<Segmentation> seg = read_frames(file);
  if (!seg) return seg.error();
  const Result<Grid> grid = grid_of(file, *seg);
  if (!grid) return grid.error();
  if (const Status checked = check_grid(file, *grid); !checked) return checked.error();
  if (const Status straight = check_straight(file, *seg, *grid); !straight) return straight.error();
  // the pixels first: memory for the volume is taken only if the file holds what its header promises
  const Result<std::string> bytes =
      bytes_of_frames(file, *seg, std::size_t(grid->size.x) * std::size_t(grid->size.y));
  if (!bytes) return bytes.error();
  LabelVolume labels{*grid, std::vector<std::uint16_t>(sample_count(*grid))};
  if (const Status filled = fill_labels(file, *seg, *bytes, labels); !filled) return filled.error();
  LabelFile read{right_handed(std::move(labels)), names_of(seg->elements), true, true};
  read.has_names = !read.names.empty();
  if (!read.has_names) read.names = usual_names();
  return read;
}

}  // namespace turgor::io
