// Outside nodes of a body that several processes share. Equals flood fills over the whole body, but joins the
// connected components of owned layers instead.
#pragma once

#include <cstdint>
#include <vector>

#include "mpi/shares.hpp"

namespace turgor::mpi {

/// 1 where a node is not of the body: air connected to the sides of the scan, and every connected component
/// of the rest except the largest. `hu`: owned layers, i fastest; `nodes`: grid of the whole body. Empty if
/// all nodes are air.
std::vector<std::uint8_t> find_outside(const Ranks& ranks, const Grid& nodes, Layers owned,
                                       const std::vector<std::int16_t>& hu, double air_max);

}  // namespace turgor::mpi
