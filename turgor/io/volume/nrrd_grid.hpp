// Grid of an NRRD file. Internal to io/.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/io/files/header_text.hpp"

namespace turgor::io {

/// "(1,0,0) none (0,1,0)": nullopt for "none"; empty if the text is malformed.
std::vector<std::optional<Vec3d>> nrrd_vectors(std::string_view text);

/// Sets spacing, origin and axes of a volume with three dimensions, and optionally a fourth without
/// direction.
Status read_nrrd_grid(const std::filesystem::path& path, const TextFields& fields, Grid& grid);

}  // namespace turgor::io
