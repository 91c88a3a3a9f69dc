// Where a CT of the scene comes from.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// A file or folder, a phantom, or a volume that whoever makes the world has at hand.
struct CtSource {
  std::filesystem::path file;
  std::string series;  // DICOM: which series, when a folder holds several
  std::optional<PhantomParams> phantom;
  std::shared_ptr<const CtVolume> given;  // goes before the others [HU]
};

}  // namespace turgor
