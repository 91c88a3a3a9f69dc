// Named tissues as chain parameters. For a published Young's modulus the chain is fitted (calibrate.hpp) to
// an incompressible half space, with a ball of 5 mm pressed in and a disc of that radius pulled
// (half_space.hpp). The fit is within 10 % of the force at every depth, and all stiffnesses are proportional
// to the modulus. The paper's tissue has the printed parameters and its authors' name.
#pragma once

#include <span>
#include <string_view>

#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

struct Tissue {
  const char* name;
  const char* source;
  double young = 0;  // 0: the source gives the parameters themselves [Pa]
  ChainParams chain;
  const char* species = "";
  const char* test = "";
};

/// All tissues, the measured human liver first.
std::span<const Tissue> tissues();
/// Tissue of a name; null if unknown.
const Tissue* find_tissue(std::string_view name);

/// Chain of a homogeneous elastic tissue, fitted as described above.
ChainParams chain_of_modulus(double young);

}  // namespace turgor::rhombus
