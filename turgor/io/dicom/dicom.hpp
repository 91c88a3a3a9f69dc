// DICOM in three steps: read the headers of a folder's files, select the files of one volume and find its
// grid, and read the samples. GDCM decodes compressed samples. Internal to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/io/dicom/dicom_elements.hpp"
#include "turgor/io/volume/ct_file.hpp"

namespace turgor::io {

/// Header of one image file, or of a frame of an enhanced image.
struct DicomSlice {
  std::filesystem::path file;
  std::string series, description, modality, patient, study, image_type, photometric, transfer_syntax;
  std::string image, image_class;  // SOPInstanceUID, SOPClassUID
  std::map<std::uint32_t, std::string>
      of_study;                          // elements that a derived series inherits: DicomOrigin::elements
  std::vector<DicomFragment> fragments;  // of compressed pixels
  int rows = 0, columns = 0, frames = 1, samples_per_pixel = 1;
  int frame = 0;                     // of an enhanced image, from 1; 0 for one file per slice
  bool is_big_endian = false;        // pixels
  bool is_deflated = false;          // pixel_offset is in the inflated data
  std::uint64_t dataset_offset = 0;  // begin of the data set in the file [bytes]
  int bits_allocated = 16, bits_stored = 16, high_bit = 15;
  bool is_signed = false, is_compressed = false;
  std::uint64_t file_size = 0, pixel_offset = 0, pixel_length = 0;  // [bytes]
  double slope = 1, intercept = 0;                                  // HU = slope · stored + intercept
  std::optional<int> padding, padding_limit;                        // stored values that mean "not measured"
  std::optional<Vec3d> position;                                    // center of the first pixel, LPS [mm]
  Vec3d row_direction, column_direction;       // along a row (growing column), along a column; 0 if missing
  double row_spacing = 0, column_spacing = 0;  // between rows, between columns [mm]
  double thickness = 0;                        // [mm]; 0 if missing
};

/// Result of reading one file: a slice, or the reason why it is not one.
struct DicomFile {
  std::filesystem::path file;
  std::optional<DicomSlice> slice;
  std::vector<DicomSlice> frames;     // of an enhanced image; they replace `slice`
  std::string problem;                // without a slice: "is empty", "truncated or corrupt DICOM file: …"
  std::optional<std::string> series;  // of a damaged file, if it could be read
  enum class Kind {
    kDamaged,
    kOtherObject,
    kNoDicom
  } kind = Kind::kDamaged;  // without a slice; the second is valid but not an image: a directory, a report,
                            // contours
};

struct DicomFolder {
  std::vector<DicomSlice> slices;  // only images, by file name
  std::vector<DicomFile> rest;     // all other files
  std::size_t file_count = 0;
};

/// A series with its slices in order, and its grid.
struct DicomVolume {
  std::vector<DicomSlice> slices;
  Grid grid;    // without the shift
  Vec3d shift;  // in-plane offset of each slice from the one before, for a tilted gantry [m]
  std::vector<std::string> notes;
};

/// True if a file begins like a DICOM file.
bool is_dicom(const std::filesystem::path& file);
DicomFile read_dicom_header(const std::filesystem::path& file);
/// Frames of an enhanced image, each as a slice; empty if its header has no positions for them.
std::vector<DicomSlice> frames_of(const DicomSlice& image, const DicomElements& set);
/// Decimal strings: "1.5\\2\\-3e1". Invalid words become NaN.
std::vector<double> decimal_numbers(std::string_view text);
/// Reads position, directions, spacing and thickness, if they are given.
void read_geometry(const DicomValues& values, DicomSlice& slice);
/// A signed or unsigned two-byte number.
std::optional<int> short_integer(std::string_view value, bool is_signed, bool is_big_endian);
/// Reads the headers of all files in a folder. `known`: one that has been read already, else null.
Result<DicomFolder> scan_dicom(const Exec& exec, const std::filesystem::path& folder, bool recursive,
                               const Progress& progress, const DicomFile* known = nullptr);
/// Checks the other files of a folder. Error: one of them is a damaged slice of the chosen series, by its
/// identifier or its name. All others give notes. The folder's `slices` are those of all series.
Status judge_rest(const DicomFolder& folder, const std::string& series, std::vector<std::string>& notes);
/// One line per series: number, slices, size, modality, description and identifier.
std::string list_series(const std::vector<DicomSlice>& slices);
/// Slices of the requested series; the error lists the series if it does not exist.
Result<std::vector<DicomSlice>> choose_series(const std::filesystem::path& folder,
                                              std::vector<DicomSlice> slices, const std::string& requested);
/// Sorts the slices along the normal. Error: not a straight stack of evenly spaced CT slices. With `may_lean`
/// an evenly tilted stack is accepted.
Result<DicomVolume> stack_slices(const std::filesystem::path& folder, std::vector<DicomSlice> slices,
                                 bool may_lean = false);
/// Straight grid around slices with a constant in-plane shift [m], and the samples on it: linear
/// interpolation within each slice, air outside.
Grid straight_grid(const Grid& grid, Vec3d shift);
CtVolume straightened(const Exec& exec, const CtVolume& ct, Vec3d shift);
/// Number of samples whose Hounsfield units differ from the stored values.
struct ChangedSamples {
  std::size_t padding = 0;  // became air
  std::size_t clamped = 0;  // were outside int16

  void operator+=(const ChangedSamples& other) { padding += other.padding, clamped += other.clamped; }
};
/// Stored bytes of a slice's pixels, as many as the file holds. `inflated`: as below.
std::string stored_bytes(const DicomSlice& slice, InflatedStream* inflated, std::size_t byte_count);
/// Hounsfield units of one uncompressed slice, columns fastest, as rows · columns samples. `inflated`: the
/// data set of a deflated file, else null; its frames are read in the order of their offsets.
Result<ChangedSamples> read_plain_samples(const DicomSlice& slice, InflatedStream* inflated,
                                          std::span<std::int16_t> hu);
/// The same for compressed slices of one size.
Result<ChangedSamples> decode_dicom_samples(const Exec& exec, std::span<const DicomSlice* const> slices,
                                            std::span<const std::span<std::int16_t>> hu,
                                            const Progress& progress);
/// Checks that the size in the compressed pixels agrees with the header.
Status check_frame(const DicomSlice& slice);
/// Converts stored values to Hounsfield units with the slice's header.
ChangedSamples convert_to_hu(const DicomSlice& slice, const char* stored, std::span<std::int16_t> hu);

/// Reads a DICOM segmentation: one bit per sample and segment. Its grid spans the first to the last slice
/// with a segment; labels are segment numbers.
Result<LabelFile> read_segmentation(const std::filesystem::path& file);
/// Names of its segments; empty if they cannot be read.
LabelNames read_segment_names(const std::filesystem::path& file);

Result<CtFile> read_dicom(const Exec& exec, const std::filesystem::path& path, const ReadOptions& options);

}  // namespace turgor::io
