// Which nodes of a body that several processes share are outside: the same answer as flood fills over the
// whole give, from the connected parts of everybody's own layers.
#pragma once

#include <cstdint>
#include <vector>

#include "mpi/shares.hpp"

namespace turgor::mpi {

/// 1 where a node is not of the body: air connected to the sides of the scan, and all but the largest
/// connected rest. `hu`: of own layers, i fastest; `nodes`: the grid of the whole. Empty: all is air.
std::vector<std::uint8_t> find_outside(const Ranks& ranks, const Grid& nodes, Layers owned,
                                       const std::vector<std::int16_t>& hu, double air_max);

}  // namespace turgor::mpi
