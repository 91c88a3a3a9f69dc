// Tissues by name, as parameters of the chain. The paper's liver is taken as printed. The others are made
// from a published Young's modulus: the chain is fitted (calibrate.hpp) to a ball of 5 mm pressed 10 mm into
// an incompressible half-space (Hertz), within 5 % of the peak force; all stiffnesses are proportional to the
// modulus.
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

/// All of them, the paper's liver first.
std::span<const Tissue> tissues();
/// Null when there is none of that name.
const Tissue* find_tissue(std::string_view name);

/// The chain of a homogeneous elastic tissue, as described above.
ChainParams chain_of_modulus(double young);

}  // namespace turgor::rhombus
