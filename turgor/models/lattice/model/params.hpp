// Parameters of the lattice model: tissue law, skin law and solver. docs/scene.md describes the same values
// for scene files. The parameters do not depend on a body.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/models/prony.hpp"

namespace turgor::lattice {

enum class Method : std::uint8_t { kPbd, kVbd };
/// Order of a sweep: slabs of layers, or colors (colors.hpp).
enum class Ordering : std::uint8_t { kSlabs, kColors };
enum class SkinLaw : std::uint8_t { kArea, kFiber, kExponential };
/// Springs along the edges as in the paper, or isotropic solid cells (solid.hpp).
enum class TissueLaw : std::uint8_t { kSprings, kSolid };
/// Energy of solid cells (solid_laws.hpp).
enum class SolidEnergy : std::uint8_t { kNeoHookean, kExponential, kOgden };
constexpr int kSolidEnergyCount = 3;
struct SkinParams {
  bool enabled = true;
  SkinLaw law = SkinLaw::kFiber;
  double tension_along = 45;   // tension along Langer's lines; the area law uses the mean of both [N/m]
  double tension_across = 45;  // tension across the lines [N/m]
  double stiffness = 300;      // area and fiber law: membrane stiffness in both directions [N/m]
  double shear = 100;          // fiber law: shear stiffness; exponential: µ of the matrix [N/m]
  double amplification = 2;    // area and fiber law: stiffening with stretch, β of the paper [1]
  // Exponential law (mechanics/skin_exponential.hpp). The defaults are near those of porcine skin 1.5 mm
  // thick.
  double stiffening = 13;        // b of the matrix [1]
  double fiber_stiffness = 110;  // k1 of the fibers along Langer's lines [N/m]
  double fiber_stiffening = 20;  // k2 [1]
  double dispersion = 0;         // κ of the fibers' directions, 0 to 1/3 [1]
  Vec3d direction{1, 0, 0};      // Langer's lines, patient frame; may leave the skin surface

  friend bool operator==(const SkinParams&, const SkinParams&) = default;
};

/// Fibers of exponential cells (solid_laws.hpp).
struct FiberParams {
  double stiffness = 0;      // k1; 0 = none [Pa]
  double stiffening = 0;     // k2 [1]
  Vec3d direction{1, 0, 0};  // patient frame; 0 = long axis of the label of a layer, found at loading

  friend bool operator==(const FiberParams&, const FiberParams&) = default;
};

/// Permanent set (solver/viscosity.hpp): a share of the stress beyond a strain relaxes for good.
struct PermanentSet {
  double strain = 0;  // equivalent strain from which on tissue sets [1]
  double share = 0;   // of the stress beyond that strain; 0 = none [1]
  double time = 1;    // of relaxation [s]

  friend bool operator==(const PermanentSet&, const PermanentSet&) = default;
};

/// Layer of tissue by its depth below the skin, or the region of a label or of CT values.
struct TissueLayer {
  std::string name;
  double thickness = 0;               // 0 = the rest of the body, for the last layer [m]
  std::optional<SolidEnergy> energy;  // none = that of the body
  double young = 0;                   // [Pa]
  double poisson = 0;                 // [1]
  double stiffening = 0;              // as TissueParams::stiffening [1]
  FiberParams fiber;
  double slide = 1;  // factor of the shear modulus; a layer of little shear lets its neighbors slide [1]
  std::optional<Prony> prony;  // relaxation; none = that of the body
  // A region has one of these and no thickness.
  int label = 0;                            // of a segmentation; 0 = none
  std::optional<std::array<double, 2>> hu;  // from, to [HU]

  friend bool operator==(const TissueLayer&, const TissueLayer&) = default;
};
/// True for a layer that a label or CT values choose, false for one by depth.
inline bool is_region(const TissueLayer& layer) { return layer.label > 0 || layer.hu.has_value(); }

struct TissueParams {
  TissueLaw law = TissueLaw::kSprings;
  double gas = 1e3, fat = 5e3, muscle = 2e4, bone = 1e7;  // Young's modulus [Pa]
  double air_max = -449;                                  // air below this value [HU]
  double fat_max = -30;                                   // fat below this value [HU]
  double bone_min = 200;                                  // bone above this value [HU]
  double volume = 0;      // springs: bulk modulus of the volume energy over Young's modulus [1]
  double poisson = 0.45;  // solid: Poisson's ratio, 0 to 0.499 [1]
  // Solid: cells that the body fills in part bear in proportion, and skin bears in them. Off by default,
  // since other laws, layers and viscosity need whole cells, and thin bodies step slower.
  bool partial_cells = false;
  SolidEnergy energy = SolidEnergy::kNeoHookean;
  double stiffening = 0;                 // exponential: b; Ogden: α [1]
  FiberParams fiber;                     // exponential
  PermanentSet set;                      // solid
  std::vector<TissueLayer> layers;       // solid: those by depth from the skin inward, and regions
  Prony prony;                           // solid: relaxation; the moduli are static ones
  std::map<int, double> young_of_label;  // Young's modulus by label of a segmentation [Pa]

  friend bool operator==(const TissueParams&, const TissueParams&) = default;
};

struct SolverParams {
  Method method = Method::kVbd;
  Ordering ordering = Ordering::kSlabs;
  int sweeps = 5;
  double damping = 1.2;      // velocities decay by exp(-damping·t) [1/s]
  double pbd_stiffness = 1;  // PBD: factor of the density-based stiffness, in [0, 1] [1]
  bool pbd_volume = false;   // PBD: also project the volumes of tetrahedra
  bool coarse = true;        // VBD with solid tissue: coarse correction
  double sleep_speed = 0;    // VBD: slower rows sleep; 0 disables sleep [m/s]
};

struct Params {
  Int3 block{4, 4, 4};  // voxels per cell of the lattice
  bool fix_bone = true;
  bool fix_ends = false;  // fixes the end layers of the scan (head and feet)
  TissueParams tissue;
  SkinParams skin;
  SolverParams solver;
};

}  // namespace turgor::lattice
