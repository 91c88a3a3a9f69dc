#include "turgor/sim/scene/tissue_presets.hpp"

#include <numbers>

#include <fmt/format.h>

#include "turgor/models/rhombus/tissues.hpp"

namespace turgor {

namespace {

// sources of several presets
constexpr const char* kLimbSource =
    "Neumann, Owings, Schimmoeller et al. 2018 (Scientific Data 5, 180193; data doi 10.18735/S5R97F)";
constexpr const char* kBrainSource = "Budday, Sommer, Birkl et al. 2017 (Acta Biomaterialia 48, 319)";

/// Modulus in kPa with its scatter.
PresetValue young_kpa(double value, double low = 0, double high = 0) {
  return {"young", value * 1e3, "Pa", low * 1e3, high * 1e3};
}

// -------------------------------------------------------------------------------------------------- solids

/// Tissues of known modulus that rhombus chains have.
void add_tissues_of_chains(std::vector<TissuePreset>& list) {
  for (const rhombus::Tissue& tissue : rhombus::tissues())
    if (tissue.young > 0)
      list.push_back({tissue.name,
                      PresetKind::kSolid,
                      "linear",
                      {{"young", tissue.young, "Pa"}},
                      tissue.test,
                      tissue.species,
                      tissue.source});
}

void add_limbs(std::vector<TissuePreset>& list) {
  struct Limb {
    const char* site;
    double fat[3], muscle[3];  // median and quartiles [kPa]
  };
  constexpr Limb kLimbs[] = {{"forearm", {66.48, 43.82, 98.43}, {51.71, 39.88, 64.32}},
                             {"upper-arm", {106.2, 58.47, 179.9}, {48.04, 40.97, 62.61}},
                             {"thigh", {114.3, 56.71, 188.3}, {49.75, 39.3, 57.83}},
                             {"lower-leg", {65.71, 37.63, 118.9}, {145.4, 106.9, 183.0}}};
  const std::string test =
      "ultrasound probe pressed on the front of the limb, stress over strain of the layer; median and "
      "quartiles of 95 people";
  for (const char* layer : {"muscle", "fat"})
    for (const Limb& limb : kLimbs) {
      const auto& [value, low, high] = *layer == 'm' ? limb.muscle : limb.fat;
      list.push_back({fmt::format("{}-{}", layer, limb.site),
                      PresetKind::kSolid,
                      "linear",
                      {young_kpa(value, low, high)},
                      test,
                      "human, living",
                      kLimbSource});
    }
  // moduli of `turgor validate measured`, which fits them together
  const std::string fitted =
      "strains of fat and muscle below an ultrasound probe, lower arm and upper leg, medians of 95 people; "
      "fit of this project: two layers of exponential cells on bone, Poisson's ratio 0.45";
  list.push_back({"fat-limb",
                  PresetKind::kSolid,
                  "exponential",
                  {young_kpa(39), {"stiffening", 1, "1"}},
                  fitted,
                  "human, living",
                  kLimbSource});
  list.push_back({"muscle-limb",
                  PresetKind::kSolid,
                  "exponential",
                  {young_kpa(11), {"stiffening", 1, "1"}},
                  fitted,
                  "human, living",
                  kLimbSource});
}

/// Muscle that stiffens and relaxes: values fitted to the ramps at 0.5 and 1 %/s together, whose points
/// `turgor validate measured` quotes. Times end at the length of the hold.
void add_muscle_of_compression(std::vector<TissuePreset>& list) {
  struct Muscle {
    const char *name, *direction;
    double young, stiffening, pairs[3][2];  // [kPa], [1], g [1] and τ [s]
  };
  constexpr Muscle kMuscles[] = {
      {"muscle-porcine-along", "along", 0.455, 3.25, {{0.538, 2.22}, {0.18, 29.5}, {0.124, 222}}},
      {"muscle-porcine-across", "across", 1.13, 2.47, {{0.471, 4.1}, {0.154, 62}, {0.0815, 297}}}};
  for (const auto& [name, direction, young, stiffening, pairs] : kMuscles)
    list.push_back(
        {name,
         PresetKind::kSolid,
         "exponential, three Prony pairs",
         {young_kpa(young),
          {"stiffening", stiffening, "1"},
          {"g1", pairs[0][0], "1"},
          {"tau1", pairs[0][1], "s"},
          {"g2", pairs[1][0], "1"},
          {"tau2", pairs[1][1], "s"},
          {"g3", pairs[2][0], "1"},
          {"tau3", pairs[2][1], "s"}},
         fmt::format("unconfined compression by 30 % {} the fibers at 0.5 and 1 %/s, held for 300 s; fit of "
                     "this project: E = 3 μ of the static stress",
                     direction),
         "pig",
         "Van Loocke, Lyons, Simms 2008 (Journal of Biomechanics 41, 1555)"});
}

void add_soft_solids(std::vector<TissuePreset>& list) {
  // E = 3 μ of incompressible tissue
  list.push_back(
      {"fat",
       PresetKind::kSolid,
       "neo-Hookean, one Prony pair",
       {young_kpa(1.59, 0.66, 2.52), {"g1", 0.39, "1", 0.36, 0.42}, {"tau1", 700, "s", 445, 955}},
       "magnetic resonance images and inverse finite elements; E = 3 μ of the stated μ = 0.53 ± 0.31 kPa",
       "pig",
       "Sims, Stait-Gardner, Fong et al. 2010 (Biomechanics and Modeling in Mechanobiology 9, 703)"});
  const std::string brain =
      "tension, compression and simple shear together; fit of this project: one Ogden term, E = 3 μ";
  list.push_back({"brain-cortex",
                  PresetKind::kSolid,
                  "ogden",
                  {young_kpa(4.39), {"alpha", -18.7, "1"}},
                  brain,
                  "human",
                  kBrainSource});
  list.push_back({"brain-corona-radiata",
                  PresetKind::kSolid,
                  "ogden",
                  {young_kpa(2.02), {"alpha", -24.0, "1"}},
                  brain,
                  "human",
                  kBrainSource});
}

void add_silicones(std::vector<TissuePreset>& list) {
  struct Silicone {
    const char* name;
    double young, deviation;  // [kPa]
  };
  constexpr Silicone kSilicones[] = {
      {"00-50", 152.7, 4.8},        {"00-50-12.5t", 111.1, 6.44}, {"00-50-25t", 89.49, 2.33},
      {"00-30", 97.26, 4.16},       {"00-30-12.5t", 73.18, 1.17}, {"00-30-25t", 65.68, 2.83},
      {"00-10", 54.21, 2.38},       {"00-10-12.5t", 37.3, 1.28},  {"00-10-25t", 27.39, 0.79},
      {"00-10-37.5t", 19.37, 0.83}, {"00-10-50t", 15.52, 0.4},    {"00-10-62.5t", 12.17, 0.52},
      {"00-10-75t", 8.81, 0.12},    {"00-10-87.5t", 7.92, 0.26},  {"00-10-100t", 5.42, 0.77}};
  for (const auto& [name, young, deviation] : kSilicones)
    list.push_back({fmt::format("ecoflex-{}", name),
                    PresetKind::kSolid,
                    "linear",
                    {young_kpa(young, young - deviation, young + deviation)},
                    "compression; mean and standard deviation (t: percent of thinner)",
                    "silicone",
                    "Dawood, Zhang, Osman et al. 2026 (Tissue Phantom Materials Database, an early release, "
                    "CC BY 4.0)"});
}

void add_paper_chain(std::vector<TissuePreset>& list) {
  for (const rhombus::Tissue& tissue : rhombus::tissues())
    if (tissue.young == 0)
      list.push_back({tissue.name,
                      PresetKind::kChain,
                      "rhombus chain",
                      {{"chain.normal", tissue.chain.normal, "N/m"},
                       {"chain.tangential", tissue.chain.tangential, "N/m"},
                       {"chain.decay", tissue.chain.decay, "1"},
                       {"chain.angle", tissue.chain.angle * 180 / std::numbers::pi, "degrees"},
                       {"chain.side", tissue.chain.side, "m"}},
                      tissue.test,
                      tissue.species,
                      tissue.source});
}

// ------------------------------------------------------------------------------------------------- surfaces

/// Tension of living skin.
void add_skin_tension(std::vector<TissuePreset>& list) {
  struct Tension {
    const char *name, *test, *source;
    double tension;  // [N/m]
  };
  constexpr const char
      *kLargest = "Flynn, Taberner, Nielsen 2011 (Biomechanics and Modeling in Mechanobiology 10, 27)",
      *kRange = "Flynn, Taberner, Nielsen 2011 (Annals of Biomedical Engineering 39, 1935)";
  constexpr Tension kTensions[] = {
      {"skin-forearm-low", "in-plane pushes by a robot, lower part of the anterior forearm: largest tension",
       kLargest, 6.2},
      {"skin-forearm-high", "in-plane pushes by a robot, upper part of the anterior forearm: largest tension",
       kLargest, 11.4},
      {"skin-upper-arm", "in-plane pushes by a robot, posterior upper arm: largest tension", kLargest, 5.6},
      {"skin-taut-low",
       "pushes by a robot in many directions, arms of several people: least stress, 28 kPa, at 1.5 mm",
       kRange, 42},
      {"skin-taut-high",
       "pushes by a robot in many directions, arms of several people: largest stress, 92 kPa, at 1.5 mm",
       kRange, 138}};
  for (const auto& [name, test, source, tension] : kTensions)
    list.push_back(
        {name, PresetKind::kSkin, "fiber", {{"tension", tension, "N/m"}}, test, "human, living", source});
}

/// Skin that stiffens, as a membrane 1.5 mm thick: µ, b, k1, k2 and κ of the exponential law.
void add_skin_that_stiffens(std::vector<TissuePreset>& list) {
  constexpr double kThickness = 0.0015;  // [m]
  struct Skin {
    const char* name;
    double shear, stiffening, fiber_stiffness, fiber_stiffening, dispersion;  // µ, k1 [Pa]
    const char *test, *species, *source;
  };
  constexpr double kDermisShear = 0.2014e6;
  constexpr Skin kSkins[] = {
      {"skin-porcine", 81.3e3, 11.8, 123e3, 14.4, 0,
       "biaxial stretch, three protocols of one specimen; fit of this project, as skin 1.5 mm thick", "pig",
       "Tac, Sahli Costabal, Tepole 2022 (Computer Methods in Applied Mechanics and Engineering 398, "
       "115248)"},
      {"skin-dermis", kDermisShear, 0, 243.6 * kDermisShear, 0.1327, 0.1404,
       "uniaxial tension of excised skin of the back, dispersion from histology; k1 = 243.6 μ; as one family "
       "of "
       "fibers along Langer's lines and skin 1.5 mm thick",
       "human", "Ní Annaidh, Bruyère, Destrade et al. 2012 (Annals of Biomedical Engineering 40, 1666)"}};
  for (const Skin& skin : kSkins)
    list.push_back({skin.name,
                    PresetKind::kSkin,
                    "exponential",
                    {{"shear", skin.shear * kThickness, "N/m"},
                     {"stiffening", skin.stiffening, "1"},
                     {"fiber_stiffness", skin.fiber_stiffness * kThickness, "N/m"},
                     {"fiber_stiffening", skin.fiber_stiffening, "1"},
                     {"dispersion", skin.dispersion, "1"}},
                    skin.test,
                    skin.species,
                    skin.source});
}

void add_fabrics(std::vector<TissuePreset>& list) {
  struct Fabric {
    const char* name;
    double density, warp, cross, weft, shear, bend_warp, bend_weft;  // [kg/m²], [N/m], [N·m]
  };
  // small-strain row of the stretch table; bending at 0 and 90 degrees, least curvature
  constexpr Fabric kFabrics[] = {
      {"black-denim", 0.324, 205.352005, 10.234077, 1013.88629, 53.387184, 6.4196457e-05, 9.6951576e-05},
      {"ponte-roma", 0.284, 31.146198, -12.802702, 44.028667, 31.896357, 3.6348366e-05, 3.7157593e-05},
      {"interlock", 0.187, 16.593832, -14.69599, 34.477123, 36.860302, 2.3191698e-05, 1.4267624e-05},
      {"rib-knit", 0.276, 42.871021, -0.234556, 65.166023, 83.175644, 4.6237591e-05, 3.2243889e-05},
      {"sparkle-sweat", 0.224, 12.486332, -19.875324, 3.272434, 17.616289, 5.9469658e-05, 4.5625023e-05}};
  for (const Fabric& f : kFabrics)
    list.push_back({f.name,
                    PresetKind::kFabric,
                    "sheet",
                    {{"density", f.density, "kg/m²"},
                     {"warp", f.warp, "N/m"},
                     {"weft", f.weft, "N/m"},
                     {"shear", f.shear, "N/m"},
                     // a negative coupling, which four of the fabrics have, is set to 0
                     {"poisson", f.cross > 0 ? f.cross / f.weft : 0, "1"},
                     {"rigidity_warp", f.bend_warp, "N·m"},
                     {"rigidity_weft", f.bend_weft, "N·m"}},
                    "planar stretch at small strain, bending under its own weight",
                    "fabric",
                    "Wang, O'Brien, Ramamoorthi 2011 (ACM Transactions on Graphics 30(4), 71)"});
  list.push_back(
      {"median-fabric",
       PresetKind::kFabric,
       "sheet",
       {{"density", 0.1968, "kg/m²", 0.1037, 0.2936},
        {"rigidity_warp", 1.378e-5, "N·m", 4.117e-6, 3.594e-5},
        {"rigidity_weft", 8.756e-6, "N·m", 3.319e-6, 2.369e-5}},
       "bending; median and quartiles of 618 fabrics",
       "fabric",
       "Feng, Huang, Xu, Wang 2022 (ACM Transactions on Graphics 41(6), data set ClothDrapeTester)"});
}

std::vector<TissuePreset> make_presets() {
  std::vector<TissuePreset> list;
  add_tissues_of_chains(list), add_limbs(list), add_muscle_of_compression(list), add_soft_solids(list);
  add_silicones(list), add_paper_chain(list);
  add_skin_tension(list), add_skin_that_stiffens(list), add_fabrics(list);
  return list;
}

}  // namespace

std::span<const TissuePreset> tissue_presets() {
  static const std::vector<TissuePreset> kPresets = make_presets();
  return kPresets;
}

const TissuePreset* find_preset(std::string_view name, PresetKind kind) {
  for (const TissuePreset& preset : tissue_presets()) {
    const bool fits =
        preset.kind == kind || (kind == PresetKind::kChain && preset.kind == PresetKind::kSolid);
    if (fits && preset.name == name) return &preset;
  }
  return nullptr;
}

const PresetValue* find_value(const TissuePreset& preset, std::string_view key) {
  for (const PresetValue& value : preset.values)
    if (value.key == key) return &value;
  return nullptr;
}

double value_or(const TissuePreset* preset, std::string_view key, double fallback) {
  const PresetValue* value = preset ? find_value(*preset, key) : nullptr;
  return value ? value->value : fallback;
}

const char* kind_name(PresetKind kind) {
  switch (kind) {
    case PresetKind::kSolid:
      return "tissue";
    case PresetKind::kChain:
      return "chain";
    case PresetKind::kSkin:
      return "skin";
    case PresetKind::kFabric:
      break;
  }
  return "fabric";
}

std::string value_text(const PresetValue& value) {
  // kilopascals from 100 Pa on, megapascals from 1 MPa on; no unit for ratios
  const bool kilo = value.unit == "Pa" && value.value >= 100, mega = kilo && value.value >= 1e6;
  const double scale = mega ? 1e-6 : kilo ? 1e-3 : 1;
  const std::string unit = mega ? "MPa" : kilo ? "kPa" : value.unit == "1" ? "" : value.unit;
  std::string text = fmt::format("{:.4g}{}{}", value.value * scale, unit.empty() ? "" : " ", unit);
  if (value.low < value.high)
    text += fmt::format(" ({:.4g} to {:.4g})", value.low * scale, value.high * scale);
  return text;
}

}  // namespace turgor
