#include "turgor/io/dicom.hpp"

#include <atomic>

#include <fmt/format.h>

namespace turgor {

namespace fs = std::filesystem;

namespace io {

namespace {

/// A file stands for its series: its folder is read, and other series there do not count.
Result<std::vector<DicomSlice>> slices_beside(const Exec& exec, const fs::path& file,
                                              const Progress& progress) {
  const Result<std::optional<DicomSlice>> named = read_dicom_header(file);
  if (!named) return named.error();
  if (!*named)
    return Error{fmt::format("{}: a DICOM file without an image; expected a slice of a CT", file.string())};
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  Result<DicomFolder> found = scan_dicom(exec, folder, false, progress);
  if (!found) return found.error();
  std::erase_if(found->slices, [&](const DicomSlice& s) { return s.series != (*named)->series; });
  return std::move(found->slices);
}

Result<std::vector<DicomSlice>> slices_in(const Exec& exec, const fs::path& folder,
                                          const ReadOptions& options, const Progress& progress) {
  Result<DicomFolder> found = scan_dicom(exec, folder, true, progress);
  if (!found) return found.error();
  if (!found->unreadable.empty()) {
    const std::size_t more = found->unreadable.size() - 1;
    return Error{found->unreadable[0] + (more ? fmt::format(" (and {} more)", more) : "")};
  }
  if (found->slices.empty())
    return Error{fmt::format("{}: no DICOM images among {} files; expected the slices of a CT",
                             folder.string(), found->file_count)};
  return choose_series(folder, std::move(found->slices), options.series);
}

Status read_plain(const Exec& exec, std::span<const DicomSlice* const> slices,
                  std::span<const std::span<std::int16_t>> hu, const Progress& progress) {
  std::vector<std::optional<Error>> errors(slices.size());
  std::atomic<std::size_t> done{0};
  parallel_for(exec, slices.size(), [&](std::size_t k) {
    if (const Status read = read_plain_samples(*slices[k], hu[k]); !read) errors[k] = read.error();
    if (progress) progress(double(++done) / double(slices.size()));
  });
  for (const auto& error : errors)
    if (error) return *error;
  return Done{};
}

Status read_all_samples(const Exec& exec, const DicomVolume& volume, CtVolume& ct, const Progress& progress) {
  const std::size_t area = std::size_t(ct.grid.size.x) * std::size_t(ct.grid.size.y);
  std::vector<const DicomSlice*> plain, compressed;
  std::vector<std::span<std::int16_t>> plain_hu, compressed_hu;
  for (std::size_t k = 0; k < volume.slices.size(); k++) {
    const DicomSlice& slice = volume.slices[k];
    (slice.is_compressed ? compressed : plain).push_back(&slice);
    (slice.is_compressed ? compressed_hu : plain_hu).push_back(std::span(ct.samples).subspan(k * area, area));
  }
  if (Status read = read_plain(exec, plain, plain_hu, progress); !read) return read;
  return decode_dicom_samples(exec, compressed, compressed_hu, progress);
}

}  // namespace

}  // namespace io

std::string list_dicom_series(const Exec& exec, const fs::path& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) return {};
  const Result<io::DicomFolder> found = io::scan_dicom(exec, folder, true, {});
  return found && !found->slices.empty() ? io::list_series(found->slices) : std::string{};
}

namespace io {

Result<CtFile> read_dicom(const Exec& exec, const fs::path& path, const ReadOptions& options) {
  const auto part = [&](double begin, double end) -> Progress {
    if (!options.progress) return {};
    return [=, &options](double fraction) { options.progress(begin + (end - begin) * fraction); };
  };
  std::error_code failed;
  const bool is_folder = fs::is_directory(path, failed);
  Result<std::vector<DicomSlice>> slices =
      is_folder ? slices_in(exec, path, options, part(0, 0.3)) : slices_beside(exec, path, part(0, 0.3));
  if (!slices) return slices.error();
  Result<DicomVolume> volume = stack_slices(path, std::move(*slices));
  if (!volume) return volume.error();
  if (std::int64_t(sample_count(volume->grid)) > std::int64_t{1} << 33)
    return Error{fmt::format("{}: more samples than the largest volume of 2^33", path.string())};
  CtFile file;
  file.ct = {volume->grid, std::vector<std::int16_t>(sample_count(volume->grid))};
  if (Status read = read_all_samples(exec, *volume, file.ct, part(0.3, 1)); !read) return read.error();
  const DicomSlice& first = volume->slices.front();
  file.format = "DICOM";
  file.patient = first.patient;
  file.study = first.study;
  file.series = first.description.empty() ? first.series : first.description;
  file.modality = first.modality;
  file.files = int(volume->slices.size());
  file.notes = std::move(volume->notes);
  return file;
}

}  // namespace io
}  // namespace turgor
