// Tissues by name, as parameters of the chain. Those with a published Young's modulus have a chain that is
// fitted (calibrate.hpp) to an incompressible half space, a ball of 5 mm pressed into it and a disc of that
// radius pulled (half_space.hpp), within 10 % of the force at every depth; all stiffnesses are proportional
// to the modulus. The paper's is taken as printed, under its authors' name.
#pragma once

#include <span>
#include <string_view>

#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

struct Tissue {
  const char* name;
  const char* source;
  double young = 0;  // 0: the parameters come from the source themselves [Pa]
  ChainParams chain;
};

/// All of them, the measured human liver first.
std::span<const Tissue> tissues();
/// Null when there is none of that name.
const Tissue* find_tissue(std::string_view name);

/// The chain of a homogeneous elastic tissue, as described above.
ChainParams chain_of_modulus(double young);

}  // namespace turgor::rhombus
