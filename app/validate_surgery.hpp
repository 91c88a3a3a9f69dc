// `turgor validate surgery`: needles against closed forms and measured liver.
#pragma once

#include <filesystem>
#include <vector>

#include "app/validation.hpp"

namespace turgor {

/// Draws the force over depth of two insertions into one hole into the folder.
std::vector<Figure> validate_surgery(const Exec& exec, bool quick, const std::filesystem::path& folder);

}  // namespace turgor
