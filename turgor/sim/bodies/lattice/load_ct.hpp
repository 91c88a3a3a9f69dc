// CT of a body: from a patient's files, or from a phantom.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct LoadedCt {
  CtVolume volume;
  std::optional<LabelVolume> labels;  // of a phantom
  std::vector<std::string> notes;     // notes of the reader
  DicomOrigin origin;                 // of a DICOM series
  std::string series;                 // its description
};
Result<LoadedCt> load_ct(const Exec& exec, const CtSource& source, const Progress& progress = {});

/// Hash of samples and grid.
std::uint64_t content_hash(const CtVolume& ct);

}  // namespace turgor
