// Dilation of a mask by a box (mathematical morphology).
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// Marks all cells within `reach` cells of a marked one along every axis. Cells are 0 or 1, i fastest.
void dilate(const Exec& exec, std::vector<std::uint8_t>& mask, Int3 size, int reach);

}  // namespace turgor
