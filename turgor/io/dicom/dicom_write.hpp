// Writing CT volumes as DICOM series.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/io/volume/ct_file.hpp"

namespace turgor {

/// Origin of a volume that was never scanned.
DicomOrigin patient_alone(const std::string& name);

/// Checks that a new folder of slices can be written to this path, before the work that computes them.
Status check_dicom_goal(const std::filesystem::path& folder);
/// Writes one file per slice into a new folder, as a new series. With an origin that has images the series is
/// derived: it keeps their patient, study and frame of reference, and each slice references its source image.
Status write_dicom(const Exec& exec, const std::filesystem::path& folder, const CtVolume& ct,
                   const DicomOrigin& origin, const Progress& progress = {});

}  // namespace turgor
