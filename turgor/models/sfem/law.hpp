// Nonlinear law of the elements of a patch: neo-Hookean, or exponential as soft tissue is measured
// [Demiray 1972]. The isochoric part and the volume are apart, and small strains see the shear and bulk
// modulus of the linear material. docs/models/sfem-law.md.
//
//   Ψ = µ/2b (exp(b (Ī₁ − 3)) − 1) + κ/2 (J − 1)²        Ī₁ = J^(−2/3) I_C;  b → 0: µ/2 (Ī₁ − 3) + κ/2 (J −
//   1)² P = µ c p + κ (J − 1) G        c = exp(b (Ī₁ − 3)),  r = J^(−2/3),  G = cof F,  p = r F − r I_C/3J G
//   ∂P/∂F = µ c (2b p⊗p + r 1 − ⅔ r/J (F⊗G + G⊗F) + 5/9 r I_C/J² G⊗G) + κ G⊗G
//           + (κ (J − 1) − µ c r I_C/3J) ∂G/∂F
#pragma once

#include <array>

#include "turgor/core/vec.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

/// Law of the elements in a patch.
struct Law {
  double stiffening = 0;  // b; 0 = neo-Hookean [1]
};

/// Least J and largest exponent b (Ī₁ − 3) that a solution may have.
constexpr double kLeastVolumeRatio = 0.05, kLargestLawExponent = 30;

/// Energy density of a deformation gradient [J/m³]; infinite beyond the limits above.
double law_energy(const Mat3d& f, const Moduli& m, const Law& law);

/// First Piola-Kirchhoff stress and its derivative by F. Entry (i, J) of a tensor is at 3 J + i [Pa].
struct LawStress {
  std::array<double, 9> stress{};
  std::array<double, 81> tangent{};  // symmetric
};
LawStress law_stress(const Mat3d& f, const Moduli& m, const Law& law);

/// Largest principal Green strain |½ (λ² − 1)| of a deformation gradient, by its norm: an upper bound [1].
double largest_strain(const Mat3d& f);

}  // namespace turgor::sfem
