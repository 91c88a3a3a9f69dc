#include "turgor/io/dicom/dicom.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "turgor/geometry/hounsfield.hpp"
#include "turgor/io/files/file_cursor.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace io {

namespace {

/// Slices of one series, and notes about the other files.
struct ChosenSlices {
  std::vector<DicomSlice> slices;
  std::vector<std::string> notes;
};

/// A single file selects its series: its folder is read, and other series in it are ignored. Another series
/// in the options is refused.
Result<ChosenSlices> slices_beside(const Exec& exec, const fs::path& file, const ReadOptions& options,
                                   const Progress& progress) {
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  // The header is read under the name that the folder lists, so that the scan does not read it again.
  const DicomFile named = read_dicom_header(folder / file.filename());
  if (!named.slice)
    return Error{fmt::format("{}: {}; expected a slice of a CT", file.string(), named.problem)};
  Result<DicomFolder> found = scan_dicom(exec, folder, false, progress, &named);
  if (!found) return found.error();
  ChosenSlices chosen;
  const std::string series = named.slice->series;
  if (!options.series.empty()) {
    const Result<std::vector<DicomSlice>> wanted = choose_series(folder, found->slices, options.series);
    if (!wanted) return wanted.error();
    if (wanted->front().series != series)
      return Error{fmt::format("{}: a slice of series {}, not of the requested {}; name the folder instead",
                               file.string(), series, options.series)};
  }
  if (const Status rest = judge_rest(*found, series, chosen.notes); !rest) return rest.error();
  std::erase_if(found->slices, [&](const DicomSlice& s) { return s.series != series; });
  chosen.slices = std::move(found->slices);
  return chosen;
}

Error no_images(const fs::path& folder, const DicomFolder& found) {
  for (const DicomFile& f : found.rest)
    if (f.kind == DicomFile::Kind::kDamaged)
      return {fmt::format("{}: {} ({} files in {}, no DICOM image can be read)", f.file.string(), f.problem,
                          found.file_count, folder.string())};
  return {fmt::format("{}: no DICOM images among {} files; expected the slices of a CT", folder.string(),
                      found.file_count)};
}

Result<ChosenSlices> slices_in(const Exec& exec, const fs::path& folder, const ReadOptions& options,
                               const Progress& progress) {
  const Result<DicomFolder> found = scan_dicom(exec, folder, true, progress);
  if (!found) return found.error();
  if (found->slices.empty()) return no_images(folder, *found);
  Result<std::vector<DicomSlice>> slices = choose_series(folder, found->slices, options.series);
  if (!slices) return slices.error();
  ChosenSlices chosen{std::move(*slices), {}};
  const std::string series = chosen.slices.front().series;
  if (const Status rest = judge_rest(*found, series, chosen.notes); !rest) return rest.error();
  return chosen;
}

/// Groups of slices that are read one after the other: all frames of a deflated file, which is inflated once,
/// in the order of the file; otherwise single slices.
std::vector<std::vector<std::size_t>> read_together(std::span<const DicomSlice* const> slices) {
  std::vector<std::vector<std::size_t>> together;
  std::map<fs::path, std::size_t> deflated;
  for (std::size_t k = 0; k < slices.size(); k++) {
    const bool is_new = !slices[k]->is_deflated || deflated.emplace(slices[k]->file, together.size()).second;
    if (is_new) together.emplace_back();
    together[is_new ? together.size() - 1 : deflated[slices[k]->file]].push_back(k);
  }
  for (std::vector<std::size_t>& group : together)
    std::ranges::sort(group, {}, [&](std::size_t k) { return slices[k]->pixel_offset; });
  return together;
}

Result<ChangedSamples> read_plain(const Exec& exec, std::span<const DicomSlice* const> slices,
                                  std::span<const std::span<std::int16_t>> hu, const Progress& progress) {
  std::vector<Result<ChangedSamples>> read(slices.size(), ChangedSamples{});
  std::atomic<std::size_t> done{0};
  const std::vector<std::vector<std::size_t>> together = read_together(slices);
  parallel_for(exec, together.size(), [&](std::size_t n) {
    const DicomSlice& first = *slices[together[n].front()];
    std::optional<InflatedStream> inflated;
    if (first.is_deflated) inflated.emplace(deflated_dataset(first.file, first.dataset_offset));
    for (const std::size_t k : together[n]) {
      read[k] = read_plain_samples(*slices[k], inflated ? &*inflated : nullptr, hu[k]);
      if (progress) progress(double(++done) / double(slices.size()));
    }
  });
  ChangedSamples changed;
  for (const auto& slice : read) {
    if (!slice) return slice.error();
    changed += *slice;
  }
  return changed;
}

Result<ChangedSamples> read_all_samples(const Exec& exec, const DicomVolume& volume, CtVolume& ct,
                                        const Progress& progress) {
  const std::size_t area = std::size_t(ct.grid.size.x) * std::size_t(ct.grid.size.y);
  std::vector<const DicomSlice*> plain, compressed;
  std::vector<std::span<std::int16_t>> plain_hu, compressed_hu;
  for (std::size_t k = 0; k < volume.slices.size(); k++) {
    const DicomSlice& slice = volume.slices[k];
    (slice.is_compressed ? compressed : plain).push_back(&slice);
    (slice.is_compressed ? compressed_hu : plain_hu).push_back(std::span(ct.samples).subspan(k * area, area));
  }
  Result<ChangedSamples> changed = read_plain(exec, plain, plain_hu, progress);
  if (!changed) return changed;
  Result<ChangedSamples> decoded = decode_dicom_samples(exec, compressed, compressed_hu, progress);
  if (!decoded) return decoded;
  *changed += *decoded;
  return changed;
}

/// Notes about samples that differ from the stored values.
void note_changes(const std::vector<DicomSlice>& slices, const ChangedSamples& changed,
                  std::vector<std::string>& notes) {
  const auto padded =
      std::find_if(slices.begin(), slices.end(), [](const auto& s) { return s.padding.has_value(); });
  if (changed.padding > 0)
    notes.push_back(
        fmt::format("{} became air ({} HU): their stored value means \"not measured\" "
                    "(PixelPaddingValue {})",
                    counted(changed.padding, "sample"), kAirHu, *padded->padding));
  if (changed.clamped > 0)
    notes.push_back(fmt::format("{} outside -32768 to 32767 HU {} clamped",
                                counted(changed.clamped, "sample"), changed.clamped == 1 ? "was" : "were"));
  const auto is_fraction = [](double v) { return v != std::floor(v); };
  if (std::any_of(slices.begin(), slices.end(),
                  [&](const DicomSlice& s) { return is_fraction(s.slope) || is_fraction(s.intercept); }))
    notes.push_back(
        fmt::format("samples were rounded to integer Hounsfield units: RescaleSlope {}, "
                    "RescaleIntercept {}",
                    slices.front().slope, slices.front().intercept));
}

int file_count(const std::vector<DicomSlice>& slices) {
  std::set<fs::path> files;
  for (const DicomSlice& slice : slices) files.insert(slice.file);
  return int(files.size());
}

DicomOrigin origin_of(const std::vector<DicomSlice>& slices) {
  DicomOrigin origin{slices.front().of_study, {}};
  for (const DicomSlice& slice : slices)
    origin.images.push_back({slice.image, slice.image_class, slice.frame, *slice.position * 1e-3});
  return origin;
}

}  // namespace

Result<CtFile> read_dicom(const Exec& exec, const fs::path& path, const ReadOptions& options) {
  const auto sub_progress = [&](double begin, double end) -> Progress {
    if (!options.progress) return {};
    return [=, &options](double fraction) { options.progress(begin + (end - begin) * fraction); };
  };
  // slices of one series
  std::error_code failed;
  const bool is_folder = fs::is_directory(path, failed);
  Result<ChosenSlices> chosen = is_folder ? slices_in(exec, path, options, sub_progress(0, 0.3))
                                          : slices_beside(exec, path, options, sub_progress(0, 0.3));
  if (!chosen) return chosen.error();
  // grid
  Result<DicomVolume> volume = stack_slices(path, std::move(chosen->slices), options.straighten);
  if (!volume) return volume.error();
  const bool leans = norm(volume->shift) > 0;
  const Grid grid = leans ? straight_grid(volume->grid, volume->shift) : volume->grid;
  if (std::int64_t(sample_count(grid)) > std::int64_t{1} << 33)
    return Error{fmt::format("{}: more samples than the largest volume of 2^33", path.string())};
  if (Status checked = check_grid(path, grid); !checked) return checked.error();
  // samples
  CtFile file;
  file.ct = {volume->grid, std::vector<std::int16_t>(sample_count(volume->grid))};
  const Result<ChangedSamples> changed = read_all_samples(exec, *volume, file.ct, sub_progress(0.3, 1));
  if (!changed) return changed.error();
  if (leans) file.ct = straightened(exec, file.ct, volume->shift);
  // metadata and notes
  const DicomSlice& first = volume->slices.front();
  file.format = "DICOM";
  file.origin = origin_of(volume->slices);
  file.patient = first.patient;
  file.study = first.study;
  file.series = first.description.empty() ? first.series : first.description;
  file.modality = first.modality;
  file.files = file_count(volume->slices);
  file.notes = std::move(chosen->notes);
  file.notes.insert(file.notes.end(), volume->notes.begin(), volume->notes.end());
  note_changes(volume->slices, *changed, file.notes);
  if (std::string doubt = doubt_of_hounsfield_units(file.ct); !doubt.empty()) file.notes.push_back(doubt);
  return file;
}

}  // namespace io
}  // namespace turgor
