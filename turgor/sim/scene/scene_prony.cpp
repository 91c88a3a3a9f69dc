#include "turgor/sim/scene/scene_prony.hpp"

namespace turgor {

namespace {

const Allowed kTime = inside(0, 1000, "s"), kPair = within(1e-6, 1e5, "1, s");

struct Share {
  double g, tau;  // of the instantaneous stress [1], [s]
};

/// pᵢ = gᵢ / (1 − Σ gⱼ). At most three shares, whose sum is below 1.
Prony prony_of_shares(const std::vector<Share>& shares) {
  double rest = 1;
  for (const Share& share : shares) rest -= share.g;
  Prony prony;
  for (std::size_t i = 0; i < shares.size(); i++) prony.pairs[i] = {shares[i].g / rest, shares[i].tau};
  return prony;
}

/// Rows [g, τ] of `pairs`; empty, and a problem, if they are wrong.
std::vector<Share> read_shares(SceneTable& table, const toml::node& node) {
  const std::string expected =
      "one to three pairs [g, τ] with g between 0 and 1, Σ g below 1 and τ [s] above 0";
  const auto* rows = node.as_array();
  if (!rows || rows->empty() || rows->size() > kMostPronyPairs)
    return table.fail_value("pairs", node, expected), std::vector<Share>{};
  std::vector<Share> shares;
  double sum = 0;
  for (const toml::node& row : *rows) {
    const std::vector<double> v = table.numbers("pairs", row, kPair);
    if (v.empty()) return {};  // a problem was added
    if (v.size() != 2 || !(v[0] < 1)) return table.fail_value("pairs", row, expected), std::vector<Share>{};
    shares.push_back({v[0], v[1]});
    sum += v[0];
  }
  if (!(sum < 0.999))
    return table.fail("pairs", fmt::format("expected shares whose sum is below 0.999, found {:.4g}", sum)),
           std::vector<Share>{};
  return shares;
}

void add_rows_of_pairs(const std::string& component, const Prony& prony, const TissuePreset* preset,
                       bool is_given, std::vector<TissueRow>& rows) {
  const double whole = 1 + total_ratio(prony);
  constexpr const char* kKeys[kMostPronyPairs][2] = {{"g1", "tau1"}, {"g2", "tau2"}, {"g3", "tau3"}};
  for (std::size_t i = 0; i < std::size_t(pair_count(prony)); i++)
    rows.push_back(tissue_row(component, "Prony pair", preset,
                              {{kKeys[i][0], prony.pairs[i].ratio / whole, "1", is_given},
                               {kKeys[i][1], prony.pairs[i].time, "s", is_given}}));
}

/// Pairs of a preset that the table names; a problem if it has none, or if the table has pairs too.
Prony pairs_of_preset(SceneTable& table, const TissuePreset& preset) {
  const Prony prony = prony_of(&preset, {});
  if (pair_count(prony) == 0)
    table.fail("preset",
               fmt::format("expected a preset with Prony pairs, such as \"muscle-porcine-across\"; {} "
                           "has none",
                           preset.name));
  for (const char* key : {"ratio", "time", "pairs"})
    if (table.has(key)) table.fail(key, "the pairs are those of preset: remove preset, or this key");
  return prony;
}

}  // namespace

Prony prony_of(const TissuePreset* preset, const Prony& fallback) {
  std::vector<Share> shares;
  constexpr const char* kKeys[kMostPronyPairs][2] = {{"g1", "tau1"}, {"g2", "tau2"}, {"g3", "tau3"}};
  for (const auto& [share, time] : kKeys)
    if (const double g = value_or(preset, share, 0); g > 0) shares.push_back({g, value_or(preset, time, 0)});
  return shares.empty() ? fallback : prony_of_shares(shares);
}

void check_pairs_of_preset(SceneTable& owner, const TissuePreset* preset) {
  const toml::node* node = owner.find("viscosity");
  if (!preset || !node || !node->is_table() || !node->as_table()->empty()) return;
  if (pair_count(prony_of(preset, {})) == 0)
    owner.fail(
        "viscosity",
        fmt::format("an empty table takes the pairs of preset {}, which has none: name another preset "
                    "with pairs, as viscosity = {{ preset = \"muscle-porcine-across\" }}, or give pairs",
                    preset->name));
}

void read_viscosity(SceneTable table, const TissuePreset* preset, Prony& prony, std::vector<TissueRow>& rows,
                    const std::string& component) {
  // pairs of another preset
  const TissuePreset* other =
      read_preset(table, "preset", PresetKind::kSolid,
                  {"a preset of `turgor tissues` whose pairs these are, instead of those "
                   "of the tissue's own preset",
                   "that of the tissue"});
  if (other) preset = other, prony = pairs_of_preset(table, *other);

  // one pair
  PronyPair& first = prony.pairs[0];
  const bool has_one = table.has("ratio") || table.has("time"), has_pairs = table.has("pairs");
  if (has_one) prony = one_pair(first.ratio, first.time);
  table.read("ratio", first.ratio, within(0, 100),
             "the instantaneous stiffness is 1 + ratio times the static one");
  table.read("time", first.time, kTime, "relaxation time of that");

  // up to three pairs
  table.describe("pairs", "1, s", "none",
                 "instead: one to three pairs `[[g, τ], …]`; the share g of the instantaneous stiffness "
                 "relaxes with the time τ, and moduli are static ones");
  const toml::node* node = table.find("pairs");
  const std::size_t rows_given = node && node->is_array() ? node->as_array()->size() : 0;
  for (std::size_t n = 0; n < std::min(rows_given, std::size_t(kMostPronyPairs)); n++)
    table.describe(fmt::format("pairs[{}]", n), "1, s", "none", "[g, τ] of a pair", kPair);
  if (has_one && has_pairs)
    table.fail("pairs", "viscosity is either one pair, ratio and time, or pairs, not both");
  else if (node)
    prony = prony_of_shares(read_shares(table, *node));
  table.finish();
  add_rows_of_pairs(component, prony, preset, has_one || has_pairs, rows);
}

}  // namespace turgor
