// Where a CT of the scene comes from.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "turgor/geometry/phantom.hpp"

namespace turgor {

/// A file or folder, or a phantom.
struct CtSource {
  std::filesystem::path file;
  std::string series;  // DICOM: which series, when a folder holds several
  std::optional<PhantomParams> phantom;
};

}  // namespace turgor
