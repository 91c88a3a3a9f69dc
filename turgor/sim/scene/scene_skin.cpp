#include "turgor/sim/scene/scene_skin.hpp"

#include <algorithm>

#include "turgor/models/lattice/mechanics/skin_calibration.hpp"

namespace turgor {

using lattice::SkinLaw;

const char* skin_law_name(SkinLaw law) {
  switch (law) {
    case SkinLaw::kArea:
      return "area";
    case SkinLaw::kFiber:
      return "fiber";
    case SkinLaw::kExponential:
      return "exponential";
  }
  return "";
}

void apply_skin_preset(const TissuePreset* preset, lattice::SkinParams& skin) {
  if (!preset) return;
  if (find_value(*preset, "fiber_stiffness")) skin.law = SkinLaw::kExponential;
  const std::pair<const char*, double*> values[] = {{"tension", &skin.tension_along},
                                                    {"tension", &skin.tension_across},
                                                    {"shear", &skin.shear},
                                                    {"stiffening", &skin.stiffening},
                                                    {"fiber_stiffness", &skin.fiber_stiffness},
                                                    {"fiber_stiffening", &skin.fiber_stiffening},
                                                    {"dispersion", &skin.dispersion}};
  for (const auto& [key, value] : values) *value = value_or(preset, key, *value);
}

void check_skin_preset(SceneTable& body, const TissuePreset* preset, const lattice::SkinParams& skin) {
  if (preset && find_value(*preset, "fiber_stiffness") && skin.law != SkinLaw::kExponential)
    body.fail("skin",
              fmt::format("preset {} has values of law = \"exponential\" only: remove law = \"{}\", or "
                          "the preset",
                          preset->name, skin_law_name(skin.law)));
}

void read_skin_stiffness(SceneTable& table, lattice::SkinParams& skin) {
  table.read("stiffness", skin.stiffness, positive("N/m"), "area and fiber law: of the membrane");
  table.read("shear", skin.shear, not_negative("N/m"),
             "fiber law: shear stiffness between the fibers; exponential law: µ of the matrix");
  table.read("amplification", skin.amplification, not_negative("1"),
             "area and fiber law: how fast skin stiffens when stretched");
  table.read("stiffening", skin.stiffening, within(0, 1000),
             "exponential law: b of the matrix, how fast it stiffens with strain");
  table.read("fiber_stiffness", skin.fiber_stiffness, not_negative("N/m"),
             "exponential law: k1 of the fibers along Langer's lines");
  table.read("fiber_stiffening", skin.fiber_stiffening, within(0, 1000),
             "exponential law: k2 of the fibers, how fast they stiffen with strain");
  table.read("dispersion", skin.dispersion, within(0, 0.3333),
             "exponential law: κ, scatter of the fibers around Langer's lines; 0: all parallel, 1/3: none "
             "preferred");
  // keys of other laws
  const bool exponential = skin.law == SkinLaw::kExponential;
  for (const char* key : {"stiffness", "amplification"})
    if (exponential && table.has(key))
      table.fail(key, fmt::format("skin.law = \"exponential\" has shear, stiffening, fiber_stiffness and "
                                  "fiber_stiffening: remove {}, or set law = \"fiber\"",
                                  key));
  for (const char* key : {"stiffening", "fiber_stiffness", "fiber_stiffening", "dispersion"})
    if (!exponential && table.has(key))
      table.fail(key,
                 fmt::format("only skin.law = \"exponential\" has {0}: set that law, or remove {0}", key));
  if (exponential && !table.is_listed() && !(skin.shear > 0))
    table.fail("shear", "the matrix of exponential skin has a stiffness; expected more than 0 N/m");
}

void check_skin_tension(SceneTable& table, const lattice::SkinParams& skin) {
  const double most = std::max(skin.tension_along, skin.tension_across);
  if (skin.law == SkinLaw::kExponential) {
    if (skin.shear > 0 && !lattice::stretch_of_tension(skin))
      table.fail(
          "tension",
          fmt::format("expected a tension that the law bears at a stretch below 4, found {} and {} N/m",
                      skin.tension_along, skin.tension_across));
    return;
  }
  if (most >= skin.stiffness)
    table.fail("tension", fmt::format("expected less than the skin's stiffness, {} N/m, found {} N/m",
                                      skin.stiffness, most));
}

void add_skin_rows(const SceneTable& table, const lattice::SkinParams& skin, const TissuePreset* preset,
                   std::vector<TissueRow>& rows) {
  const char* law = skin_law_name(skin.law);
  const bool has_tension = table.has("tension");
  const LawValue tension{"tension", skin.tension_along, "N/m", has_tension},
      shear{"shear", skin.shear, "N/m", table.has("shear")};
  rows.push_back(tissue_row("skin, across Langer's lines", law, preset,
                            {{"tension", skin.tension_across, "N/m", has_tension}}, kSkinDefaults));
  if (skin.law != SkinLaw::kExponential) {
    rows.push_back(tissue_row("skin", law, preset,
                              {tension,
                               {"stiffness", skin.stiffness, "N/m", table.has("stiffness")},
                               shear,
                               {"amplification", skin.amplification, "1", table.has("amplification")}},
                              kSkinDefaults));
    return;
  }
  rows.push_back(tissue_row("skin", law, preset,
                            {tension, shear, {"stiffening", skin.stiffening, "1", table.has("stiffening")}},
                            kExponentialSkinDefaults));
  rows.push_back(tissue_row("skin, fibers", law, preset,
                            {{"fiber_stiffness", skin.fiber_stiffness, "N/m", table.has("fiber_stiffness")},
                             {"fiber_stiffening", skin.fiber_stiffening, "1", table.has("fiber_stiffening")},
                             {"dispersion", skin.dispersion, "1", table.has("dispersion")}},
                            kExponentialSkinDefaults));
}

}  // namespace turgor
