// Types that every reader and writer of CT volumes and segmentations shares: options, the result of reading,
// and the DICOM origin that derived series inherit.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "turgor/core/progress.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/volume/organ_names.hpp"

namespace turgor {

struct ReadOptions {
  std::string series;       // DICOM: SeriesInstanceUID or number in the list; empty = the only one
  Progress progress;        // may be empty
  bool straighten = false;  // DICOM: resample slices of a tilted gantry
};

/// DICOM data that a derived series inherits: patient, study and frame of reference, so that viewers open
/// both together, and the position of each source image.
struct DicomOrigin {
  struct Image {
    std::string uid, class_uid;  // SOPInstanceUID, SOPClassUID
    int frame = 0;               // of an enhanced image, from 1
    Vec3d position;              // of its first pixel, LPS [m]
  };
  std::map<std::uint32_t, std::string> elements;  // group · 65536 + element → value as stored
  std::vector<Image> images;                      // in no order
};

/// A CT with the metadata of its file.
struct CtFile {
  CtVolume ct;
  DicomOrigin origin;                            // DICOM only
  std::string format;                            // "DICOM", "NIfTI", "NRRD", "MetaImage"
  std::string patient, study, series, modality;  // DICOM only; may be empty
  int files = 1;
  std::vector<std::string> notes;  // data that was ignored while reading: sentences
};

/// A segmentation and the names of its labels.
struct LabelFile {
  LabelVolume labels;
  LabelNames names;         // from the file, else those of the usual tool
  bool has_names = false;   // the names are from the file
  bool is_cropped = false;  // DICOM: samples outside its grid have no label
};

}  // namespace turgor
