// The CT of a body: read from a patient's files, or made as a phantom.
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
  std::optional<LabelVolume> labels;  // phantoms know their own anatomy
  std::vector<std::string> notes;     // what was left out while reading
  DicomOrigin origin;                 // of a DICOM series
};
Result<LoadedCt> load_ct(const Exec& exec, const CtSource& source, const Progress& progress = {});

/// Equal for equal samples on equal grids.
std::uint64_t content_hash(const CtVolume& ct);

}  // namespace turgor
