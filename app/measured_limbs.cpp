// Limbs of living people under a flat probe: a lattice of fat and muscle in layers on rigid bone. Moduli are
// fitted to the strains of the layers at two sites, and predict the strain of the whole thickness at all.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "app/least_squares.hpp"
#include "app/measured_table.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

/// Medians of 95 people a site; quartiles of the strain. Skin counts as fat, since its strain is quantized.
struct LimbSite {
  const char* name;
  double area;               // of the probe [mm²]
  double pressure;           // [kPa]
  double low, median, high;  // strain of the whole thickness [1]
  double fat_strain, muscle_strain;
  double fat, muscle;  // thickness, of fat with skin [mm]
};
constexpr LimbSite kFitted[] = {
    {"lower arm", 360, 15.1, 0.1897, 0.2431, 0.3019, 0.1818, 0.2655, 6.56, 11.32},
    {"upper leg", 675, 11.54, 0.1705, 0.1982, 0.2293, 0.07685, 0.2344, 10.9, 29.1}};
constexpr LimbSite kPredicted[] = {
    {"upper arm", 360, 15.48, 0.226, 0.2637, 0.3068, 0.1122, 0.2989, 5.26, 25.64},
    {"lower leg", 675, 15.13, 0.0831, 0.1092, 0.1404, 0.13, 0.1025, 6.17, 34.33}};
constexpr const char* kLimbSource =
    "MULTIS: Neumann, Owings, Schimmoeller et al. 2018 (Scientific Data 5, 180193; data doi 10.18735/S5R97F)";

struct LimbModuli {
  double fat, muscle;  // [kPa]
};
struct LimbStrains {
  double whole, fat, muscle;  // [1]
};

/// Cells between the probe and rigid walls that hold the muscle on two sides, as a compartment between bones
/// does.
constexpr int kNoWalls = -1, kNearWalls = 1;

/// Layered slab on fixed nodes, with the probe's side as a whole number of cells.
struct LimbSlab {
  static constexpr int kProbe = 4, kBeside = 5;  // cells
  double side, height;                           // of the probe and of a cell [m]
  int cells;                                     // along the depth
  lattice::Model model;

  LimbSlab(const LimbSite& site, LimbModuli moduli, int walls) : side(std::sqrt(site.area) * 1e-3) {
    const double thickness = (site.fat + site.muscle) * 1e-3;
    cells = std::max(4, int(std::lround(thickness / (side / kProbe))));
    height = thickness / cells;
    lattice::Params params;
    params.skin.enabled = false;
    params.tissue.law = lattice::TissueLaw::kSolid;
    params.tissue.energy = lattice::SolidEnergy::kExponential;
    params.tissue.stiffening = 1;
    params.tissue.poisson = 0.45;
    params.tissue.layers = {{"fat", site.fat * 1e-3, {}, moduli.fat * 1e3, 0.45, 1},
                            {"muscle", 0, {}, moduli.muscle * 1e3, 0.45, 1}};
    params.solver.sweeps = 12, params.solver.damping = 4;
    const int wide = kProbe + 2 * kBeside + 1;
    const auto is_fixed = [&](Int3 p) {
      const bool is_beside = p.y <= kBeside - walls || p.y >= kBeside + kProbe + walls;
      return p.z == 0 || (walls != kNoWalls && is_beside && p.z * height <= site.muscle * 1e-3);
    };
    lattice::BodyNodes nodes = lattice::block_nodes({.size = {wide, wide, cells + 1},
                                                     .spacing = side / kProbe,
                                                     .young = params.tissue.muscle,
                                                     .is_fixed = is_fixed});
    nodes.grid.spacing.z = height;
    model = lattice::assemble(Exec(1), nodes, nullptr, params).value();
  }
  int slot(int i, int j, int k) const { return node_slot(model.anatomy.lattice, {i, j, k}); }
};

/// Strains under the median pressure: the probe goes down slowly until it bears that pressure.
LimbStrains pressed_limb(const Exec& exec, const LimbSite& site, LimbModuli moduli, int walls = kNoWalls) {
  const LimbSlab slab(site, moduli, walls);
  std::vector<lattice::NodeContact> contacts;
  constexpr int kFirst = LimbSlab::kBeside, kLast = LimbSlab::kBeside + LimbSlab::kProbe;
  for (int j = kFirst; j <= kLast; j++)
    for (int i = kFirst; i <= kLast; i++)
      contacts.push_back({.slot = slab.slot(i, j, slab.cells), .normal = {0, 0, -1}});
  std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });

  lattice::State state = lattice::make_state(slab.model);
  const double thickness = slab.height * slab.cells;
  const int center = (kFirst + kLast) / 2, interface = int(std::lround(site.muscle * 1e-3 / slab.height));
  LimbStrains last{}, found{};
  double pressure = 0;
  constexpr double kStrainStep = 0.01;
  for (int n = 1; n <= 60; n++) {
    const double depth = n * kStrainStep * thickness;
    double force = 0;
    for (int settle = 0; settle < 6; settle++) {
      for (lattice::NodeContact& c : contacts) c.target = {0, 0, Real(-depth)};
      lattice::step(exec, slab.model, state, {.contacts = contacts}, 1.0 / 30);
      force = 0;
      for (const lattice::NodeContact& c : contacts) force -= double(c.force.z);
    }
    const double now = force / site.area * 1e3;  // [kPa]
    const auto down = [&](int k) {
      return -double(state.motion.u[std::size_t(slab.slot(center, center, k))].z);
    };
    const double muscle_height = interface * slab.height;
    const LimbStrains strains{down(slab.cells) / thickness,
                              (down(slab.cells) - down(interface)) / (thickness - muscle_height),
                              down(interface) / muscle_height};
    if (now >= site.pressure) {
      const double share = (site.pressure - pressure) / (now - pressure);
      found = {last.whole + share * (strains.whole - last.whole), last.fat + share * (strains.fat - last.fat),
               last.muscle + share * (strains.muscle - last.muscle)};
      return found;
    }
    last = strains, pressure = now;
  }
  return last;
}

void add_strain(const LimbSite& site, const std::string& name, const LimbStrains& strains,
                MeasuredResult& result) {
  result.rows.push_back({fmt::format("limb, {}: strain at {} kPa", name, site.pressure), kLimbSource, "1",
                         site.median, site.low, site.high, strains.whole});
}

void add_limb(const Exec& exec, const LimbSite& site, LimbModuli moduli, bool is_fitted,
              MeasuredResult& result) {
  add_strain(site, fmt::format("{}{}", site.name, is_fitted ? " (fitted)" : ""),
             pressed_limb(exec, site, moduli), result);
}

}  // namespace

void add_limbs(const Exec& exec, MeasuredResult& result) {
  // moduli from the strains of the layers at two sites
  const auto error = [&](const std::vector<double>& x) {
    double sum = 0;
    for (const LimbSite& site : kFitted) {
      const LimbStrains s = pressed_limb(exec, site, {std::exp(x[0]), std::exp(x[1])});
      sum += std::pow(s.fat - site.fat_strain, 2) + std::pow(s.muscle - site.muscle_strain, 2);
    }
    return sum;
  };
  const std::vector<double> x = minimize(error, {std::log(40.0), std::log(15.0)}, 0.4, 30);
  const LimbModuli moduli{std::exp(x[0]), std::exp(x[1])};
  for (const auto& [name, found] : {std::pair{"fat-limb", moduli.fat}, {"muscle-limb", moduli.muscle}}) {
    const double preset = 1e-3 * value_or(find_preset(name, PresetKind::kSolid), "young", 0);
    result.rows.push_back(band_row(fmt::format("preset {}: modulus that fits the limbs", name), kLimbSource,
                                   "kPa", preset, 0.03 * preset, found));
  }
  for (const LimbSite& site : kFitted) add_limb(exec, site, moduli, true, result);
  for (const LimbSite& site : kPredicted) add_limb(exec, site, moduli, false, result);

  // the lower leg again, with the compartment in which its muscle lies, and with a stiffer muscle
  const LimbSite& leg = kPredicted[1];
  add_strain(leg,
             fmt::format("{} between rigid walls {:.1f} mm beside the probe", leg.name,
                         kNearWalls * std::sqrt(leg.area) / LimbSlab::kProbe),
             pressed_limb(exec, leg, moduli, kNearWalls), result);
  add_strain(leg, fmt::format("{} with three times the modulus of muscle", leg.name),
             pressed_limb(exec, leg, {moduli.fat, 3 * moduli.muscle}), result);
}

}  // namespace turgor
