// Human brain under compression, tension and simple shear (Budday et al. 2017): an Ogden law of one term,
// fitted to two of the three tests, predicts the third, at a point of the material. A cube of lattice cells
// that sticks to its plates, as a specimen must in tension and shear, shows how far the test itself matters.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/least_squares.hpp"
#include "app/measured_table.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

constexpr const char* kBrainSource = "Budday, Sommer, Birkl et al. 2017 (Acta Biomaterialia 48, 319)";

/// Stretch, or amount of shear, and nominal stress [kPa].
struct BrainPoint {
  double at, stress;
};
constexpr std::size_t kBrainPoints = 8, kBrainTests = 3;
enum BrainTest : std::size_t { kCompression, kTension, kShearTest };
constexpr const char* kBrainTestNames[kBrainTests] = {"compression", "tension", "shear"};

/// Quoted points of the published curves, one row a test.
struct BrainRegion {
  const char *name, *file;
  BrainPoint points[kBrainTests][kBrainPoints];
};
constexpr BrainRegion kBrainRegions[] = {{"cortex",
                                          "cortex",
                                          {{{0.9875, -0.0659},
                                            {0.975, -0.1479},
                                            {0.9625, -0.2375},
                                            {0.95, -0.3504},
                                            {0.9375, -0.4866},
                                            {0.925, -0.6579},
                                            {0.9125, -0.8837},
                                            {0.9, -1.1484}},
                                           {{1.0125, 0.0462},
                                            {1.025, 0.0838},
                                            {1.0375, 0.1175},
                                            {1.05, 0.1488},
                                            {1.0625, 0.1856},
                                            {1.075, 0.2366},
                                            {1.0875, 0.3125},
                                            {1.1, 0.4151}},
                                           {{0.025, 0.0294},
                                            {0.05, 0.0633},
                                            {0.075, 0.0983},
                                            {0.1, 0.1412},
                                            {0.125, 0.1942},
                                            {0.15, 0.2698},
                                            {0.175, 0.3791},
                                            {0.2, 0.5435}}}},
                                         {"corona radiata",
                                          "corona-radiata",
                                          {{{0.9875, -0.0387},
                                            {0.975, -0.08},
                                            {0.9625, -0.1305},
                                            {0.95, -0.2024},
                                            {0.9375, -0.2959},
                                            {0.925, -0.4127},
                                            {0.9125, -0.5723},
                                            {0.9, -0.7591}},
                                           {{1.0125, 0.0235},
                                            {1.025, 0.0423},
                                            {1.0375, 0.0572},
                                            {1.05, 0.0721},
                                            {1.0625, 0.0869},
                                            {1.075, 0.105},
                                            {1.0875, 0.1292},
                                            {1.1, 0.1582}},
                                           {{0.025, 0.0159},
                                            {0.05, 0.0318},
                                            {0.075, 0.0488},
                                            {0.1, 0.0681},
                                            {0.125, 0.0964},
                                            {0.15, 0.1347},
                                            {0.175, 0.1878},
                                            {0.2, 0.2611}}}}};

/// Nominal stress of an incompressible Ogden law of one term, for µ = 1:
///   stretch   P = 2/α (λ^(α−1) − λ^(−α/2−1))
///   shear     P = 2/α (λ^α − λ^(−α)) λ/(1 + λ²),  λ = γ/2 + √(1 + γ²/4)
double brain_stress(BrainTest test, double alpha, double at) {
  const double scale = 2 / alpha;
  if (test != kShearTest) return scale * (std::pow(at, alpha - 1) - std::pow(at, -alpha / 2 - 1));
  const double longest = at / 2 + std::sqrt(1 + at * at / 4);
  return scale * (std::pow(longest, alpha) - std::pow(longest, -alpha)) * longest / (1 + longest * longest);
}

struct OgdenValues {
  double alpha = 0, shear = 0;  // exponent [1], µ [kPa]
};

/// Values that fit some tests together.
OgdenValues fit_brain(const BrainRegion& region, std::span<const BrainTest> tests) {
  std::vector<double> measured;
  for (const BrainTest test : tests)
    for (const BrainPoint& p : region.points[test]) measured.push_back(p.stress);
  // µ enters linearly; α is the best of a scan over both signs
  OgdenValues best;
  double least = INFINITY;
  for (int n = -600; n <= 400; n++) {
    if (n == 0) continue;
    const double alpha = 0.1 * n;
    std::vector<std::vector<double>> column(1);
    for (const BrainTest test : tests)
      for (const BrainPoint& p : region.points[test]) column[0].push_back(brain_stress(test, alpha, p.at));
    const NonNegativeFit fit = fit_non_negative(column, measured);
    if (fit.squared_error < least) least = fit.squared_error, best = {alpha, fit.coefficients[0]};
  }
  return best;
}

/// Rows and curve of one test, predicted by the values of the others.
void add_brain_test(const BrainRegion& region, BrainTest test, const OgdenValues& values,
                    MeasuredResult& result) {
  const std::span<const BrainPoint> points = region.points[test];
  const double half = 0.1 * std::abs(points.back().stress);
  MeasuredCurve curve{fmt::format("brain-{}-{}.svg", region.file, kBrainTestNames[test]),
                      fmt::format("Brain, {}, {}, Ogden law", region.name, kBrainTestNames[test]),
                      test == kShearTest ? "amount of shear" : "stretch",
                      "nominal stress [kPa]",
                      {}};
  for (const BrainPoint& p : points)
    curve.points.push_back({p.at, p.stress, half, values.shear * brain_stress(test, values.alpha, p.at)});
  const std::string name = fmt::format("brain, {}, {}, Ogden law: ", region.name, kBrainTestNames[test]);
  result.rows.push_back(band_row(name + "stress at the end", kBrainSource, "kPa", points.back().stress, half,
                                 curve.points.back().predicted));
  result.rows.push_back(
      {name + "rms over the largest stress", kBrainSource, "1", 0, 0, 0.1, relative_rms(curve)});
  if (test == kCompression) std::reverse(curve.points.begin(), curve.points.end());
  result.curves.push_back(std::move(curve));
}

/// Row of a preset: its error in all three tests, relative to the largest stress.
void add_brain_preset(const BrainRegion& region, MeasuredResult& result) {
  const std::string name = fmt::format("brain-{}", region.file);
  const TissuePreset& preset = *find_preset(name, PresetKind::kSolid);
  const double alpha = value_or(&preset, "alpha", 0), shear = 1e-3 * value_or(&preset, "young", 0) / 3;
  MeasuredCurve all;
  for (std::size_t test = 0; test < kBrainTests; test++)
    for (const BrainPoint& p : region.points[test])
      all.points.push_back({p.at, p.stress, 0, shear * brain_stress(BrainTest(test), alpha, p.at)});
  result.rows.push_back({fmt::format("preset {}, three tests: rms over the largest stress", name),
                         kBrainSource, "1", 0, 0, 0.05, relative_rms(all)});
}

// ------------------------------------------------------------------------------------------------- body

/// Nominal stress of a cube of Ogden cells between plates to which it sticks [kPa]: force of the upper plate
/// over its area.
double stuck_cube(const Exec& exec, const OgdenValues& values, BrainTest test, double at) {
  constexpr int kCells = 6, kSteps = 150, kLoading = 30;
  constexpr double kSide = 0.005;  // [m]
  lattice::Params params;
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.tissue.energy = lattice::SolidEnergy::kOgden;
  params.tissue.poisson = 0.499;
  params.tissue.stiffening = values.alpha;
  params.solver.sweeps = 30, params.solver.damping = 20;
  const lattice::Model model =
      lattice::block_model({.size = {kCells + 1, kCells + 1, kCells + 1},
                            .spacing = kSide / kCells,
                            .young = 2 * (1 + params.tissue.poisson) * values.shear * 1e3,
                            .skin_on_top = false,
                            .is_fixed = [](Int3 p) { return p.z == 0; }},
                           params);
  std::vector<lattice::NodeContact> plate;
  for (int j = 0; j <= kCells; j++)
    for (int i = 0; i <= kCells; i++)
      plate.push_back({.slot = node_slot(model.anatomy.lattice, {i, j, kCells}), .is_held = true});
  std::sort(plate.begin(), plate.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });

  lattice::State state = lattice::make_state(model);
  for (int n = 1; n <= kSteps; n++) {
    const double share = std::min(1.0, double(n) / kLoading);
    for (lattice::NodeContact& c : plate)
      c.target = test == kShearTest ? Vec3{Real(share * at * kSide), 0, 0}
                                    : Vec3{0, 0, Real(share * (at - 1) * kSide)};
    lattice::step(exec, model, state, {.contacts = plate}, 1.0 / 60);
  }
  double force = 0;
  for (const lattice::NodeContact& c : plate) force += double(test == kShearTest ? c.force.x : c.force.z);
  return force / (kSide * kSide) * 1e-3;
}

}  // namespace

void add_brain(const Exec& exec, bool quick, MeasuredResult& result) {
  constexpr BrainTest kOthers[kBrainTests][2] = {
      {kTension, kShearTest}, {kCompression, kShearTest}, {kCompression, kTension}};
  constexpr BrainTest kAll[] = {kCompression, kTension, kShearTest};
  for (const BrainRegion& region : kBrainRegions) {
    for (const BrainTest test : kAll) add_brain_test(region, test, fit_brain(region, kOthers[test]), result);
    add_brain_preset(region, result);
    if (quick) continue;
    const OgdenValues values = fit_brain(region, kAll);
    for (const BrainTest test : kAll) {
      const BrainPoint& last = region.points[test][kBrainPoints - 1];
      result.rows.push_back(band_row(
          fmt::format("brain, {}, {}, cube that sticks to its plates, values of all tests: stress at the end",
                      region.name, kBrainTestNames[test]),
          kBrainSource, "kPa", last.stress, 0.1 * std::abs(last.stress),
          stuck_cube(exec, values, test, last.at)));
    }
  }
}

}  // namespace turgor
