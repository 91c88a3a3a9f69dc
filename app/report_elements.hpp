// What turgor validate sfem says of thin layers and of kinds of elements: tables on standard output, the same
// for the report, and bounds.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "app/validate_sfem.hpp"
#include "app/validation.hpp"

namespace turgor {

nlohmann::ordered_json report_of(const std::vector<LayerRow>& rows);
nlohmann::ordered_json report_of(const std::vector<ElementsRow>& rows);

std::vector<Figure> figures_of(const std::vector<LayerRow>& rows);
std::vector<Figure> figures_of(const std::vector<ElementsRow>& rows);

}  // namespace turgor
