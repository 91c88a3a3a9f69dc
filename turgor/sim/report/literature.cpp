#include "turgor/sim/report/literature.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

struct Published {
  std::string_view item, key, text;
};

constexpr std::array<Published, 6> kPublished{{
    {"wound", "specimen.length_change_percent", "-17.0 (people, 111 excisions; doi 10.1111/cup.12401)"},
    {"wound", "specimen.width_change_percent", "-9.5 (people, 111 excisions; doi 10.1111/cup.12401)"},
    {"wound", "change.area_percent", "9 (dogs, round excisions; arXiv 1609.07267)"},
    {"suture", "closing_force_N",
     "closed directly up to 5.4; median of those not closed 6.0 (dogs; Lackmann, Rohwedder, Maron et al. "
     "2023, "
     "Tierärztliche Praxis K 51, 386)"},
    {"tool", "shape.toughness",
     "liver 164 (76 to 185), fat 4100, cornea 3390 to 5400 (needles; doi 10.1186/s10033-022-00767-4)"},
    {"tool", "shape.entry_toughness",
     "skin 1136, skin of chicken 2800 (needles; doi 10.1186/s10033-022-00767-4)"},
}};

std::string_view published(std::string_view item, std::string_view key) {
  const auto at = std::find_if(kPublished.begin(), kPublished.end(),
                               [&](const Published& p) { return p.item == item && p.key == key; });
  return at == kPublished.end() ? std::string_view() : at->text;
}

/// Range of all presets of skin, with their sources.
std::string skin_tension() {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  std::string species, sources;
  for (const TissuePreset& preset : tissue_presets()) {
    const PresetValue* value = find_value(preset, "tension");
    if (!value || preset.kind != PresetKind::kSkin) continue;
    low = std::min(low, value->value), high = std::max(high, value->value);
    species = preset.species;
    if (sources.find(preset.source) == sources.npos) sources += "; " + preset.source;
  }
  return sources.empty() ? sources : fmt::format("{:.3g} to {:.3g} ({}{})", low, high, species, sources);
}

}  // namespace

std::string published_measure(std::string_view item, std::string_view key) {
  if (item == "wound" && (key == "tension_across_cut_N_per_m" || key == "tension_along_cut_N_per_m"))
    return skin_tension();
  return std::string(published(item, key));
}

std::string published_parameter(std::string_view key) {
  // without the table and the name of the body or tool
  const std::size_t table = key.find('.'), name = table == key.npos ? table : key.find('.', table + 1);
  if (name == key.npos) return {};
  const std::string_view item = key.substr(0, table), rest = key.substr(name + 1);
  if (item == "body" && rest == "skin.tension") return skin_tension();
  return std::string(published(item, rest));
}

}  // namespace turgor
