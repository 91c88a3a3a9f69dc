// Figures of sutures and excisions, a section of `turgor validate surgery`.
#pragma once

#include <vector>

#include "app/validation.hpp"

namespace turgor {

/// Closing forces against forces through sections and closed forms, running threads against the capstan
/// equation.
void add_sutures(const Exec& exec, bool quick, std::vector<Figure>& figures);

}  // namespace turgor
