// CT volumes and segmentations in DICOM folders (GDCM where compressed), NIfTI, NRRD and MetaImage files.
// Files are in mm, NIfTI in RAS; volumes in memory are in meters and LPS with right-handed axes. The order of
// samples along i is mirrored where a file's axes are left-handed. Errors name the file, the position in it,
// what was expected and what was found.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/dicom/dicom_write.hpp"
#include "turgor/io/volume/ct_file.hpp"
#include "turgor/io/volume/volume_write.hpp"

namespace turgor {

/// Reads a CT: a DICOM folder (or one of its files), .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd. Values become
/// Hounsfield units, rounded and clamped to int16. NaN and DICOM's padding become air.
Result<CtFile> read_ct(const Exec& exec, const std::filesystem::path& path, const ReadOptions& options = {});
/// Grid of a CT from its header alone. Error: DICOM, or a compressed file, whose slices cannot be read
/// separately.
Result<Grid> read_ct_grid(const std::filesystem::path& path);
/// Slices [begin, end) of the same file, as read_ct returns them [HU].
Result<std::vector<std::int16_t>> read_ct_slices(const Exec& exec, const std::filesystem::path& path,
                                                 int begin, int end);
/// Series of a DICOM folder from its headers, one line per series; empty for anything else. Also lists
/// folders that read_ct refuses.
std::string list_dicom_series(const Exec& exec, const std::filesystem::path& folder);
/// Reads a segmentation: .nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .mhd with integers in 0…65535, or a DICOM
/// segmentation with segments that do not overlap.
Result<LabelFile> read_labels(const std::filesystem::path& path);
/// The same, reoriented to the axes of a CT. Error: its samples are not at those of the CT.
Result<LabelFile> read_labels_of(const std::filesystem::path& path, const Grid& ct);
/// Label names of a segmentation from its header; empty if it has none or cannot be read.
LabelNames read_label_names(const std::filesystem::path& path);
/// Directions: a three-component image (.nrrd, .nii.gz, .mha) in the patient frame LPS.
Result<VectorVolume> read_vectors(const std::filesystem::path& path);

/// Writes .nii, .nii.gz, .nrrd or .mha, by extension. Compressed where the format allows it.
Status write_ct(const std::filesystem::path& path, const CtVolume& ct, const Exec& exec = Exec(1));
Status write_labels(const std::filesystem::path& path, const LabelVolume& labels);
Status write_scalars(const std::filesystem::path& path, const ScalarVolume& volume);
/// Components in mm, LPS.
Status write_displacement(const std::filesystem::path& path, const VectorVolume& displacement);

}  // namespace turgor
