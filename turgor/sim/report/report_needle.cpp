#include "turgor/sim/report/report_needle.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/sim/report/quantity.hpp"

namespace turgor {

namespace {

using namespace units;

constexpr Unit kMillijoules{"mJ", "mJ", 1e3}, kToughness{"J_per_m2", "J/m²"},
    kBendingStiffness{"N_m2", "N·m²"};
constexpr std::size_t kMostNeedleSamples = 2000;  // limit of the series

/// Force along the needle, positive against a push [N].
double push_force(const ForceSample& s) { return dot(s.force, s.axes.column[2]); }

/// Sample with the longest shaft in the tissue; the first one of equals.
ForceSample deepest_sample(const TouchingTool& tool) {
  ForceSample deepest;
  for (const ForceSample& s : tool.samples)
    if (s.needle.inserted > deepest.needle.inserted) deepest = s;
  return deepest;
}

struct NeedleInput {
  const TouchingTool& tool;
  ForceSample deepest;
  double deflection_max = 0;  // of the tip [m]
};
/// A quantity of needles that bend.
Json if_bent(const NeedleInput& n, double value) {
  return n.tool.tool.needle->bending > 0 ? Json(value) : absent();
}
double largest_deflection(const TouchingTool& tool) {
  double most = 0;
  for (const ForceSample& s : tool.samples) most = std::max(most, norm(s.needle.deflection));
  return most;
}
double parts_of_work(const contact::NeedleWork& w) {
  return w.cutting + w.friction + w.spreading + w.elastic + w.others;
}
/// A part of the force at the deepest insertion.
Json share(const NeedleInput& n, double force) {
  const contact::NeedleReading& r = n.deepest.needle;
  const double all = r.cutting + r.spreading + r.friction;
  return all > 0 ? Json(force / all) : absent();
}

using N = NeedleInput;
const Quantity<N> kNeedle[] = {
    {"length", kMillimeters, "", [](const N& n) -> Json { return n.tool.tool.needle->length; }},
    {"diameter", kMillimeters, "", [](const N& n) -> Json { return n.tool.tool.needle->diameter; }},
    {"toughness", kToughness, "", [](const N& n) -> Json { return n.tool.tool.needle->toughness; }},
    {"entry_toughness", kToughness, "",
     [](const N& n) -> Json { return n.tool.tool.needle->entry_toughness; }},
    {"exit_toughness", kToughness, "", [](const N& n) -> Json { return n.tool.tool.needle->exit_toughness; }},
    {"shaft_friction", kTension, "", [](const N& n) -> Json { return n.tool.tool.needle->friction; }},
    {"spreading", kPascals, "", [](const N& n) -> Json { return n.tool.tool.needle->spreading; }},
    {"punctures", kCount, "", [](const N& n) -> Json { return n.tool.punctures; }},
    {"entry_force", kNewtons, "", [](const N& n) -> Json { return n.tool.entry_force; }},
    {"inserted_max", kMillimeters, "", [](const N& n) -> Json { return n.deepest.needle.inserted; }},
    {"bending_stiffness", kBendingStiffness, "",
     [](const N& n) { return if_bent(n, n.tool.tool.needle->bending); }},
    {"deflection_max", kMillimeters, "", [](const N& n) { return if_bent(n, n.deflection_max); }},
    {"deflection_deepest", kMillimeters, "",
     [](const N& n) { return if_bent(n, norm(n.deepest.needle.deflection)); }},
    {"share.cutting", kPercent, "", [](const N& n) { return share(n, n.deepest.needle.cutting); }},
    {"share.spreading", kPercent, "", [](const N& n) { return share(n, n.deepest.needle.spreading); }},
    {"share.friction", kPercent, "", [](const N& n) { return share(n, n.deepest.needle.friction); }},
    {"work.hand", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.hand; }},
    {"work.cutting", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.cutting; }},
    {"work.friction", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.friction; }},
    {"work.spreading", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.spreading; }},
    {"work.elastic", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.elastic; }},
    {"work.others", kMillijoules, "", [](const N& n) -> Json { return n.tool.needle_work.others; }},
    {"work.error", kPercent, "",
     [](const N& n) {
       const contact::NeedleWork& w = n.tool.needle_work;
       const double most = std::max(std::abs(w.hand), w.cutting + w.friction);
       return most > 0 ? Json((parts_of_work(w) - w.hand) / most) : absent();
     }},
};

using F = ForceSample;
const Quantity<F> kNeedleSeries[] = {
    {"time", kSeconds, "", [](const F& s) -> Json { return s.time; }},
    {"depth", kMillimeters, "", [](const F& s) -> Json { return s.depth; }},
    {"inserted", kMillimeters, "", [](const F& s) -> Json { return s.needle.inserted; }},
    {"force", kNewtons, "", [](const F& s) -> Json { return push_force(s); }},
    {"cutting", kNewtons, "", [](const F& s) -> Json { return s.needle.cutting; }},
    {"spreading", kNewtons, "", [](const F& s) -> Json { return s.needle.spreading; }},
    {"friction", kNewtons, "", [](const F& s) -> Json { return s.needle.friction; }},
    {"deflection", kMillimeters, "", [](const F& s) -> Json { return norm(s.needle.deflection); }},
};

/// Largest force before each drop by a tenth of it; smaller forces than a tenth of the largest are ignored.
const Quantity<F> kPeaks[] = {
    {"time", kSeconds, "", [](const F& s) -> Json { return s.time; }},
    {"depth", kMillimeters, "", [](const F& s) -> Json { return s.depth; }},
    {"force", kNewtons, "", [](const F& s) -> Json { return push_force(s); }},
};
std::vector<ForceSample> peaks_of(const TouchingTool& tool) {
  constexpr double kDrop = 0.9, kIgnored = 0.1;
  double largest = 0;
  for (const ForceSample& s : tool.samples) largest = std::max(largest, push_force(s));
  // rise to a maximum, then fall to a minimum
  std::vector<ForceSample> peaks;
  ForceSample highest;
  double lowest = 0;
  bool rises = true;
  for (const ForceSample& s : tool.samples) {
    const double force = push_force(s);
    if (rises && force > push_force(highest)) highest = s;
    if (!rises) lowest = std::min(lowest, force);
    if (rises && push_force(highest) > kIgnored * largest && force < kDrop * push_force(highest)) {
      peaks.push_back(highest);
      rises = false, lowest = force;
    } else if (!rises && force - lowest > kIgnored * largest) {
      rises = true, highest = s;
    }
  }
  return peaks;
}

/// Tissue with a resistance of its own, and the largest displacement of it by needles.
struct NeedleRegion {
  std::string name;
  int material = 0;   // of contact::NeedleReading
  double motion = 0;  // [m]
};

/// Insertions of the tip into another material.
struct LayerPassage {
  std::string name;
  ForceSample first, last;
};
const Quantity<LayerPassage> kLayers[] = {
    {"layer", kNone, "", [](const LayerPassage& l) -> Json { return l.name; }},
    {"from", kSeconds, "", [](const LayerPassage& l) -> Json { return l.first.time; }},
    {"to", kSeconds, "", [](const LayerPassage& l) -> Json { return l.last.time; }},
    {"from", kMillimeters, "", [](const LayerPassage& l) -> Json { return l.first.depth; }},
    {"to", kMillimeters, "", [](const LayerPassage& l) -> Json { return l.last.depth; }},
};
std::vector<LayerPassage> layers_of(const TouchingTool& tool, const std::vector<NeedleRegion>& regions) {
  std::vector<LayerPassage> passages;
  for (const NeedleRegion& region : regions) {
    bool is_open = false;
    double before = 0;
    for (const ForceSample& s : tool.samples) {
      const bool is_in = s.needle.inserted > 0 && s.needle.material == region.material;
      const bool goes_deeper = s.needle.inserted > before;
      before = s.needle.inserted;
      if (is_in && goes_deeper) {
        if (!is_open) passages.push_back({region.name, s, s});
        passages.back().last = s;
      }
      is_open = is_in && (is_open || goes_deeper);
    }
  }
  return passages;
}

const Quantity<NeedleRegion> kTargets[] = {
    {"target", kNone, "", [](const NeedleRegion& t) -> Json { return t.name; }},
    {"motion", kMillimeters, "", [](const NeedleRegion& t) -> Json { return t.motion; }},
};

Json needle_report(const TouchingTool& tool, const std::vector<NeedleRegion>& regions) {
  Json json = values_of(kNeedle, NeedleInput{tool, deepest_sample(tool), largest_deflection(tool)});
  add_rows(json, "peak_columns", "peaks", kPeaks, peaks_of(tool));
  if (!regions.empty()) {
    add_rows(json, "layer_columns", "layers", kLayers, layers_of(tool, regions));
    add_rows(json, "target_columns", "targets", kTargets, regions);
  }
  const std::size_t stride =
      std::max<std::size_t>(1, (tool.samples.size() + kMostNeedleSamples - 1) / kMostNeedleSamples);
  add_rows(json, "series_columns", "series", kNeedleSeries, tool.samples, stride);
  return json;
}

}  // namespace

Json needle_report(const TouchingTool& tool, const SfemBody& body) {
  std::vector<NeedleRegion> regions;
  for (std::size_t r = 0; r < body.inside.size(); r++)
    regions.push_back({body.inside[r].name, body.inside[r].material, body.needles.target_motion[r]});
  return needle_report(tool, regions);
}

Json needle_report(const TouchingTool& tool, const LatticeBody& body) {
  std::vector<NeedleRegion> regions;
  for (std::size_t l = 0; l < body.layers.layers.size(); l++)
    regions.push_back({body.layers.layers[l].name, int(l) + 1, body.layers.motion[l]});
  return needle_report(tool, regions);
}

}  // namespace turgor
