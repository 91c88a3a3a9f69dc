// CT volumes and segmentations in and out: DICOM folders (GDCM where compressed), NIfTI, NRRD and MetaImage.
// Files are in mm, NIfTI in RAS; everything is metres and LPS once read, and axes are right-handed:
// the order of samples along i is mirrored where a file's axes are not. Errors name the file, the place, what
// was expected and what was found.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/volume/organ_names.hpp"

namespace turgor {

struct ReadOptions {
  std::string series;       // DICOM: which series, by SeriesInstanceUID or by its number in the error's list;
                            // empty = the only one
  Progress progress;        // may be empty
  bool straighten = false;  // DICOM: slices of a tilted gantry are resampled to a straight grid, not refused
};

/// What a DICOM series that is made of another takes over: patient, study and frame of reference, so that
/// viewers open both beside each other, and which image lies where.
struct DicomOrigin {
  struct Image {
    std::string uid, class_uid;  // SOPInstanceUID, SOPClassUID
    int frame = 0;               // of an enhanced image, from 1
    Vec3d position;              // of its first pixel, LPS [m]
  };
  std::map<std::uint32_t, std::string> elements;  // group · 65536 + element → value as stored
  std::vector<Image> images;                      // in no order
};
/// The origin of what was never scanned.
DicomOrigin patient_alone(const std::string& name);

/// What a file says about its volume besides the voxels.
struct CtFile {
  CtVolume ct;
  DicomOrigin origin;                            // DICOM only
  std::string format;                            // "DICOM", "NIfTI", "NRRD", "MetaImage"
  std::string patient, study, series, modality;  // DICOM only; may be empty
  int files = 1;
  std::vector<std::string> notes;  // what was left out while reading: sentences
};

/// A CT: a DICOM folder (or one of its files), .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd. Values become
/// Hounsfield units, rounded and kept within int16; samples that are no number and DICOM's padding become
/// air.
Result<CtFile> read_ct(const Exec& exec, const std::filesystem::path& path, const ReadOptions& options = {});
/// Where the samples of a CT are by its header alone. Error: DICOM, or a compressed file, of which slices
/// cannot be read.
Result<Grid> read_ct_grid(const std::filesystem::path& path);
/// Slices [begin, end) of the same file, as read_ct gives them [HU].
Result<std::vector<std::int16_t>> read_ct_slices(const Exec& exec, const std::filesystem::path& path,
                                                 int begin, int end);
/// What a DICOM folder holds by its headers alone, one line a series; empty for anything else. Says something
/// even where read_ct refuses.
std::string list_dicom_series(const Exec& exec, const std::filesystem::path& folder);
/// A segmentation and what its labels are called.
struct LabelFile {
  LabelVolume labels;
  LabelNames names;        // the file's own, else the usual tool's
  bool has_names = false;  // are they the file's own?
  bool is_part = false;    // it says nothing beyond its grid: no label is there (DICOM)
};
/// A segmentation: .nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .mhd with whole numbers in 0…65535, or a DICOM
/// segmentation of segments that do not overlap.
Result<LabelFile> read_labels(const std::filesystem::path& path);
/// The same, laid along the axes of a CT. Error: its samples do not lie where those of the CT do.
Result<LabelFile> read_labels_of(const std::filesystem::path& path, const Grid& ct);
/// What a segmentation calls its labels, by its header alone; empty if it names none, or cannot be read.
LabelNames read_label_names(const std::filesystem::path& path);
/// Directions: a three-component image (.nrrd, .nii.gz, .mha) in the patient frame LPS.
Result<VectorVolume> read_vectors(const std::filesystem::path& path);

/// Whether a volume, or a new folder of slices, may be written there: known before the work that fills it.
Status check_volume_goal(const std::filesystem::path& path);
Status check_dicom_goal(const std::filesystem::path& folder);
/// By extension: .nii, .nii.gz, .nrrd, .mha. Compressed where the format can.
Status write_ct(const std::filesystem::path& path, const CtVolume& ct);
Status write_labels(const std::filesystem::path& path, const LabelVolume& labels);
Status write_scalars(const std::filesystem::path& path, const ScalarVolume& volume);
/// Components in mm, LPS.
Status write_displacement(const std::filesystem::path& path, const VectorVolume& displacement);
/// One file a slice, into a new folder: a series of its own. Of an origin with images it is derived: it keeps
/// their patient, study and frame of reference, and each slice names the image that it was made of.
Status write_dicom(const Exec& exec, const std::filesystem::path& folder, const CtVolume& ct,
                   const DicomOrigin& origin, const Progress& progress = {});

}  // namespace turgor
