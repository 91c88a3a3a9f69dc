// Bodies of the program beside measured values: a strip of cloth that bends under its weight over four
// decades of Γ, and silicone bars of a lattice under compression.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measured_table.hpp"
#include "app/validate_cloth_sheet.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

constexpr double kFrame = 1.0 / 60, kGravity = 9.81;

/// Height over width of a strip bent by its own weight, at Γ = ρ g L³/D (Romero et al. 2021), quoted points.
struct Bent {
  double gamma, height_over_width;
};
constexpr Bent kMaster[] = {{0.1, 0.0125011},   {0.217839, 0.0272414}, {0.554496, 0.0693052},
                            {1.20791, 0.15037}, {2.63129, 0.321977},   {6.6978, 0.759439},
                            {14.5904, 1.45225}, {37.139, 2.98758},     {80.9033, 5.13787},
                            {176.239, 8.272},   {448.605, 13.9026},    {977.237, 21.0155}};

/// Height over width of a sheet of 60 × 4 mm in vacuum, clamped between its first two columns.
double bent_sheet(const Exec& exec, double gamma, int columns) {
  constexpr double kDensity = 0.2, kLength = 0.06, kWidth = 0.004;
  cloth::Params params = sheet_params({.density = kDensity, .warp = 2000, .weft = 2000, .shear = 400});
  params.fabric.rigidity_warp = kDensity * kGravity * kLength * kLength * kLength / gamma;
  params.fabric.rigidity_weft = params.fabric.rigidity_warp;
  params.damping = {10, 0};
  params.solver.tolerance = 1e-3;
  params.collision.self = false;
  const double cell = kLength / (columns - 0.5);
  const TriMesh mesh = cloth::make_sheet({.corner = {-cell / 2, 0, 0},
                                          .side = {kLength + cell / 2, 0, 0},
                                          .up = {0, kWidth, 0},
                                          .columns = columns,
                                          .rows = std::max(2, int(std::lround(kWidth / cell)))});
  cloth::Model model = cloth::build(exec, mesh, params).value();
  cloth::State state = cloth::make_state(model);
  // hold the first two columns and let the rest fall
  std::vector<std::size_t> end;
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    if (double(mesh.vertices[v].x) < 0.6 * cell) (void)cloth::hold(model, state, int(v));
    if (double(mesh.vertices[v].x) > kLength - 1e-6) end.push_back(std::size_t(model.model_vertex[v]));
  }
  cloth::Inputs inputs{.gravity = {0, 0, -kGravity}};
  inputs.air.density = 0;
  for (int n = 0; n < 300; n++) cloth::step(exec, model, state, inputs, kFrame);
  double height = 0, width = 0;
  for (const std::size_t v : end) height -= double(state.x.z[v]), width += double(state.x.x[v]);
  return height / width;
}

/// Modulus of a bar of a lattice of solid cells, compressed along z by 0.2 % [Pa]: the end force over area
/// and strain.
double compressed_bar(const Exec& exec, double young) {
  constexpr int kLong = 25, kWide = 5;
  constexpr double kSpacing = 0.004, kStrain = 0.002;  // buckles from 0.0057 on
  lattice::Params params;
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.solver.sweeps = 40, params.solver.damping = 8;
  const lattice::Model model = lattice::block_model({.size = {kWide, kWide, kLong},
                                                     .spacing = kSpacing,
                                                     .young = young,
                                                     .skin_on_top = false,
                                                     .is_fixed = [](Int3 p) { return p.z == 0; }},
                                                    params);
  // force on the end nodes; an edge node bears half, a corner node a quarter
  const double side = (kWide - 1) * kSpacing, force = young * side * side * kStrain;
  std::vector<lattice::NodeLoad> loads;
  double shares = 0;
  const auto share = [](int i) { return i == 0 || i == kWide - 1 ? 0.5 : 1.0; };
  for (int j = 0; j < kWide; j++)
    for (int i = 0; i < kWide; i++) shares += share(i) * share(j);
  for (int j = 0; j < kWide; j++)
    for (int i = 0; i < kWide; i++)
      loads.push_back({node_slot(model.anatomy.lattice, {i, j, kLong - 1}),
                       Vec3{0, 0, Real(-force * share(i) * share(j) / shares)}});
  std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  lattice::State state = make_state(model);
  for (int n = 0; n < 150; n++) lattice::step(exec, model, state, {.loads = loads}, kFrame);
  // strain between a fifth of the length and four fifths, away from the held end
  const auto height = [&](int k) {
    double sum = 0;
    for (int j = 0; j < kWide; j++)
      for (int i = 0; i < kWide; i++)
        sum += double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, {i, j, k}))].z);
    return sum / (kWide * kWide);
  };
  const int low = kLong / 5, high = 4 * kLong / 5;
  return force / (side * side) / ((height(low) - height(high)) / ((high - low) * kSpacing));
}

}  // namespace

void add_cantilever(const Exec& exec, bool quick, MeasuredResult& result) {
  // the curve spans four decades in both axes, so errors are drawn
  MeasuredCurve curve{"cantilever.svg",
                      "A strip bent by its own weight",
                      "log₁₀ Γ, Γ = ρ g L³ / D",
                      "error of height over width [%]",
                      {}};
  for (std::size_t n = 0; n < std::size(kMaster); n += quick ? 3 : 1) {
    const auto [gamma, measured] = kMaster[n];
    const double predicted = bent_sheet(exec, gamma, quick ? 40 : 80);
    curve.points.push_back({std::log10(gamma), 0, 2, 100 * (predicted / measured - 1)});
    result.rows.push_back(
        band_row(fmt::format("strip under its weight, Γ = {:.4g}: height over width", gamma),
                 "Romero, Ly, Rasheed et al. 2021 (ACM Transactions on Graphics 40(4), 66)", "1", measured,
                 0.02 * measured, predicted));
  }
  result.curves.push_back(std::move(curve));
}

void add_silicones(const Exec& exec, bool quick, MeasuredResult& result) {
  int seen = 0;
  for (const TissuePreset& preset : tissue_presets()) {
    if (!preset.name.starts_with("ecoflex-") || (seen++ % 5 != 0 && quick)) continue;
    const PresetValue& young = *find_value(preset, "young");
    result.rows.push_back({preset.name + ", lattice bar compressed by 0.2 %: modulus", preset.source, "kPa",
                           1e-3 * young.value, 1e-3 * young.low, 1e-3 * young.high,
                           1e-3 * compressed_bar(exec, young.value)});
  }
}

}  // namespace turgor
