// Text about a step that was not finite and was undone: which body it was, and what may help.
#pragma once

#include <string>

namespace turgor {

struct World;

/// Advice after an undone step, such as "c: a higher frame rate or a smaller stiffness of its fabric may
/// help".
std::string advice_for_undone_step(const World& world);

}  // namespace turgor
