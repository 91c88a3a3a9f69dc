// Writing volumes to NIfTI, NRRD and MetaImage files.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"

namespace turgor {

/// Checks that a volume can be written to this path, before the work that computes it.
Status check_volume_goal(const std::filesystem::path& path);

}  // namespace turgor
