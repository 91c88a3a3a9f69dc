// Source of a CT in a scene.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// File or folder, phantom, or a volume in memory given by the caller.
struct CtSource {
  std::filesystem::path file;
  std::string series;  // DICOM: the selected series if a folder holds several
  std::optional<PhantomParams> phantom;
  std::shared_ptr<const CtVolume> given;  // takes precedence [HU]
};

}  // namespace turgor
