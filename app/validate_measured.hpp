// `turgor validate measured`: predictions beside measured values of tissue, silicone and strips.
#pragma once

#include <filesystem>
#include <vector>

#include "app/validation.hpp"

namespace turgor {

/// Prints the table, writes a curve per protocol into the folder, and adds the rows to the report. A
/// prediction outside of its band is a figure beyond its bound.
std::vector<Figure> validate_measured(const Exec& exec, bool quick, const std::filesystem::path& folder,
                                      nlohmann::ordered_json& report);

}  // namespace turgor
