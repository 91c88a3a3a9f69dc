#include "turgor/models/rhombus/tissues.hpp"

#include <array>

namespace turgor::rhombus {

ChainParams chain_of_modulus(double young) {
  // Fit at 1 kPa, reproduced by the test rhombus_tissues.
  return {.normal = 12.958632 * young * 1e-3,
          .tangential = 1.067752 * young * 1e-3,
          .decay = 0.2,
          .angle = 0.574733,
          .side = 0.00625,
          .stiffening = 1,
          .tip = 0.005};
}

std::span<const Tissue> tissues() {
  // name, source, Young's modulus [Pa], chain, species, test
  static const std::array<Tissue, 6> kTissues{{
      {"liver",
       "Mancia, Vlaisavljevich, Yousefi et al. 2019 (Physics in Medicine and Biology 64, 225001, table 1)",
       5.4e3, chain_of_modulus(5.4e3), "human",
       "quasistatic; E = 3 μ of μ = 1.8 ± 0.4 kPa, which the table takes from Bamber, Hill 1981, Palmeri et "
       "al. "
       "2008, Webb et al. 2011 and Honjo et al. 2014"},
      {"liver-porcine", "Samur, Sedef, Basdogan, Avtan, Duzgun 2007 (Medical Image Analysis 11, 361)", 12.5e3,
       chain_of_modulus(12.5e3), "pig", "indentation"},
      {"breast-fat", "Samani, Zubovits, Plewes 2007 (Physics in Medicine and Biology 52, 1565)", 3.25e3,
       chain_of_modulus(3.25e3), "human", "indentation of excised tissue"},
      {"breast-gland", "Samani, Zubovits, Plewes 2007 (Physics in Medicine and Biology 52, 1565)", 3.24e3,
       chain_of_modulus(3.24e3), "human", "indentation of excised tissue"},
      {"fibroadenoma", "Samani, Zubovits, Plewes 2007 (Physics in Medicine and Biology 52, 1565)", 6.41e3,
       chain_of_modulus(6.41e3), "human", "indentation of excised tissue"},
      {"zhang-2010",
       "Zhang, Song, Sun, Zou 2010 (Journal of Image and Graphics 15(2)), liver, after Cui, Song, Wu 2007 "
       "(ICMA, 2753)",
       0, ChainParams{}, "not stated", "parameters as printed"},
  }};
  return kTissues;
}

const Tissue* find_tissue(std::string_view name) {
  for (const Tissue& tissue : tissues())
    if (tissue.name == name) return &tissue;
  return nullptr;
}

}  // namespace turgor::rhombus
