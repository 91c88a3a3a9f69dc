// Where an NRRD file places its samples. Internal to io/.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/io/files/header_text.hpp"

namespace turgor::io {

/// "(1,0,0) none (0,1,0)": nothing for "none"; empty when the text is something else.
std::vector<std::optional<Vec3d>> nrrd_vectors(std::string_view text);

/// Sets spacing, origin and axes of a volume of three dimensions, and one more if that has no direction.
Status place_nrrd(const std::filesystem::path& path, const TextFields& fields, Grid& grid);

}  // namespace turgor::io
