// DICOM in three steps: what the headers of a folder's files say, which of them make up one volume and where
// it lies, and the samples of each. GDCM decodes compressed samples. Internal to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/io/ct.hpp"
#include "turgor/io/dicom/dicom_elements.hpp"

namespace turgor::io {

/// The header of one image file, or of a frame of an enhanced one.
struct DicomSlice {
  std::filesystem::path file;
  std::string series, description, modality, patient, study, image_type, photometric, transfer_syntax;
  std::string image, image_class;                 // SOPInstanceUID, SOPClassUID
  std::map<std::uint32_t, std::string> of_study;  // what a derived series takes over: DicomOrigin::elements
  std::vector<DicomFragment> fragments;           // of compressed pixels
  int rows = 0, columns = 0, frames = 1, samples_per_pixel = 1;
  int frame = 0;                     // of an enhanced image, from 1; 0 where each file is a slice
  bool is_big_endian = false;        // pixels
  bool is_deflated = false;          // pixel_offset is in what the file inflates to
  std::uint64_t dataset_offset = 0;  // where that begins in the file [bytes]
  int bits_allocated = 16, bits_stored = 16, high_bit = 15;
  bool is_signed = false, is_compressed = false;
  std::uint64_t file_size = 0, pixel_offset = 0, pixel_length = 0;  // [bytes]
  double slope = 1, intercept = 0;                                  // HU = slope · stored + intercept
  std::optional<int> padding, padding_limit;   // stored values that mean "nothing was measured here"
  std::optional<Vec3d> position;               // centre of the first pixel, LPS [mm]
  Vec3d row_direction, column_direction;       // along a row (growing column), along a column; 0 if not said
  double row_spacing = 0, column_spacing = 0;  // between rows, between columns [mm]
  double thickness = 0;                        // [mm]; 0 if not said
};

/// What one file turned out to be: a slice, or something else and why.
struct DicomFile {
  std::filesystem::path file;
  std::optional<DicomSlice> slice;
  std::vector<DicomSlice> frames;     // of an enhanced image: what to take instead of the slice
  std::string problem;                // without a slice: "is empty", "truncated or corrupt DICOM file: …"
  std::optional<std::string> series;  // of a damaged file, if that much could be read
  enum class Kind {
    kDamaged,
    kOtherObject,
    kNoDicom
  } kind = Kind::kDamaged;  // without a slice; the second
                            // is sound, but no image: a directory, a report, contours
};

struct DicomFolder {
  std::vector<DicomSlice> slices;  // images only, by name of file
  std::vector<DicomFile> rest;     // all other files
  std::size_t file_count = 0;
};

/// A series whose slices are in order, and where its samples lie.
struct DicomVolume {
  std::vector<DicomSlice> slices;
  Grid grid;    // as if they lay straight above each other
  Vec3d shift;  // of each against the one before, in its plane: of a tilted gantry [m]
  std::vector<std::string> notes;
};

/// Whether a file begins as DICOM files do.
bool is_dicom(const std::filesystem::path& file);
DicomFile read_dicom_header(const std::filesystem::path& file);
/// The frames of an enhanced image, each as a slice; empty if its header does not say where they lie.
std::vector<DicomSlice> frames_of(const DicomSlice& image, const DicomElements& set);
/// Decimal strings: "1.5\\2\\-3e1". Words that are no numbers become NaN.
std::vector<double> decimal_numbers(std::string_view text);
/// Position, directions, spacing and thickness, as far as the values say.
void read_place(const DicomValues& values, DicomSlice& slice);
/// A signed or unsigned number of two bytes.
std::optional<int> short_integer(std::string_view value, bool is_signed, bool is_big_endian);
Result<DicomFolder> scan_dicom(const Exec& exec, const std::filesystem::path& folder, bool recursive,
                               const Progress& progress);
/// Files beside a series that was chosen: an error if one of them is a damaged slice of it, or looks like one
/// by its name; notes about all others. `slices` are those of the whole folder.
Status judge_rest(const DicomFolder& folder, const std::string& series, std::vector<std::string>& notes);
/// One line a series: its number, slices, size, modality, description and identifier.
std::string list_series(const std::vector<DicomSlice>& slices);
/// The slices of the series asked for; an error that lists the series if that is not one.
Result<std::vector<DicomSlice>> choose_series(const std::filesystem::path& folder,
                                              std::vector<DicomSlice> slices, const std::string& wanted);
/// Sorts along the normal and refuses what is not a straight stack of evenly spaced CT slices, or one that
/// leans evenly if it may.
Result<DicomVolume> stack_slices(const std::filesystem::path& folder, std::vector<DicomSlice> slices,
                                 bool may_lean = false);
/// The grid around slices of which each is shifted so against the one before [m], and their samples on it,
/// linear within each slice; air where none reaches.
Grid straight_grid(const Grid& grid, Vec3d shift);
CtVolume straightened(const Exec& exec, const CtVolume& ct, Vec3d shift);
/// Samples whose Hounsfield units are not what was stored.
struct ChangedSamples {
  std::size_t padding = 0;  // became air
  std::size_t clamped = 0;  // lay outside of int16

  void operator+=(const ChangedSamples& other) { padding += other.padding, clamped += other.clamped; }
};
/// The Hounsfield units of one uncompressed slice, columns fastest, into rows · columns samples. `inflated`:
/// what its file inflates to, if that is deflated.
Result<ChangedSamples> read_plain_samples(const DicomSlice& slice, std::string_view inflated,
                                          std::span<std::int16_t> hu);
/// The same for compressed slices of one size.
Result<ChangedSamples> decode_dicom_samples(const Exec& exec, std::span<const DicomSlice* const> slices,
                                            std::span<const std::span<std::int16_t>> hu,
                                            const Progress& progress);
/// Checks that compressed pixels are of the size that the header promises, by what they say of themselves.
Status check_frame(const DicomSlice& slice);
/// Stored values, as the slice's header describes them, as Hounsfield units.
ChangedSamples convert_to_hu(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu);

/// A DICOM segmentation: one bit a sample and segment. Its grid goes from the first to the last slice that
/// has a segment; labels are the segments' numbers.
Result<LabelFile> read_segmentation(const std::filesystem::path& file);
/// What its segments are called; empty if that cannot be read.
LabelNames read_segment_names(const std::filesystem::path& file);

Result<CtFile> read_dicom(const Exec& exec, const std::filesystem::path& path, const ReadOptions& options);

}  // namespace turgor::io
