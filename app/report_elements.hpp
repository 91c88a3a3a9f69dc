// Output of `turgor validate sfem` for thin layers and element types: tables on standard output, the same
// rows for the report, and figures with bounds.
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
