// Regions by label and CT value: their shares of cells, and slabs of different laws in series.
#include "turgor/models/lattice/build/regions.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {
namespace {

const Exec kPair(2);
constexpr int kThick = 8, kWide = 40;  // of the slab [voxels]

/// A slab of dense tissue below air. Label 1 is below the voxel layer `border`, 2 above it.
struct SlabCt {
  CtVolume ct;
  LabelVolume labels;

  explicit SlabCt(int border, int wide = kWide) {
    ct = make_ct({wide, wide, kThick + 4}, [](Vec3d p) { return p.z < kThick; });
    labels.grid = ct.grid, labels.samples.assign(ct.samples.size(), 0);
    for_voxels(ct.grid, [&](Int3 p) {
      if (p.z >= kThick) return;
      ct.at(p.x, p.y, p.z) = 190;  // half of it and half of air is body
      labels.at(p.x, p.y, p.z) = p.z < border ? 1 : 2;
    });
  }
};

Params slab_params(const std::vector<TissueLayer>& layers, SolidEnergy energy) {
  Params params;
  params.block = {2, 2, 2};
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.energy = energy;
  params.tissue.stiffening = energy == SolidEnergy::kOgden ? 2 : 0;
  params.tissue.layers = layers;
  params.solver = {.sweeps = 10, .damping = 8};
  return params;
}

TissueLayer region(int label, double young, double poisson, double stiffening) {
  TissueLayer layer{.name = "region", .young = young, .poisson = poisson, .stiffening = stiffening};
  layer.label = label;
  return layer;
}

/// The slab on a fixed base.
Model slab_model(const SlabCt& slab, const Params& params) {
  BodyNodes nodes = classify(kPair, slab.ct, &slab.labels, params).value();
  for (int j = 0; j < nodes.grid.size.y; j++)
    for (int i = 0; i < nodes.grid.size.x; i++) nodes.fixed[sample_index(nodes.grid, i, j, 0)] = 1;
  return assemble(kPair, nodes, nullptr, params).value();
}

/// Settled displacement of the middle of the slab's top under a dead pressure [m].
double pressed_top(const Model& model, double pressure) {
  const Lattice& l = model.anatomy.lattice;
  const double h = double(l.spacing.x);
  const int top = kThick / 2;
  std::vector<NodeLoad> loads;
  for (int j = 0; j < l.size.y; j++)
    for (int i = 0; i < l.size.x; i++) {
      const double share = (i == 0 || i == l.size.x - 1 ? 0.5 : 1) * (j == 0 || j == l.size.y - 1 ? 0.5 : 1);
      loads.push_back({node_slot(l, {i, j, top}), {0, 0, Real(-pressure * share * h * h)}});
    }
  std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  // the load grows over a quarter of a second
  State state = make_state(model);
  std::vector<NodeLoad> now = loads;
  for (int n = 1; n <= 22; n++) {
    for (std::size_t i = 0; i < loads.size(); i++)
      now[i].force = loads[i].force * Real(std::min(1.0, n / 16.0));
    step(kPair, model, state, {.loads = now}, 1.0 / 60);
  }
  return double(state.motion.u[std::size_t(node_slot(l, {kWide / 4, kWide / 4, top}))].z);
}

/// Stretch along z of a laterally held slab that bears the nominal stress −pressure: dW/dλ from the
/// definition of the law's energy.
double confined_stretch(SolidEnergy energy, const TissueLayer& layer, double pressure) {
  const LawRatios ratios = law_ratios(energy, layer.poisson);
  const auto stress = [&](double stretch) {
    constexpr double kStep = 1e-5;
    const auto at = [&](double s) {
      return law_energy(energy, {{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, s}}},
                        {ratios.shear * layer.young, ratios.bulk * layer.young, layer.stiffening});
    };
    return (at(stretch + kStep) - at(stretch - kStep)) / (2 * kStep);
  };
  double low = 0.3, high = 1;
  for (int n = 0; n < 60; n++) (stress((low + high) / 2) < -pressure ? low : high) = (low + high) / 2;
  return (low + high) / 2;
}

// A wide slab whose halves have labels and laws of their own yields by the sum of both closed forms, at
// strains of an eighth; also where the border runs through the middle of a cell.
TEST(LatticeRegions, SlabsOfTwoLawsActInSeries) {
  for (const SolidEnergy energy : {SolidEnergy::kExponential, SolidEnergy::kOgden})
    for (const int border : {4, 5}) {
      const bool exponential = energy == SolidEnergy::kExponential;
      const std::vector<TissueLayer> layers = {region(1, 6e3, 0.2, exponential ? 6 : -9),
                                               region(2, 3e3, 0.35, exponential ? 0 : 2)};
      const Model model = slab_model(SlabCt(border), slab_params(layers, energy));
      constexpr double kPressure = 600;
      const double lower = confined_stretch(energy, layers[0], kPressure),
                   upper = confined_stretch(energy, layers[1], kPressure);
      EXPECT_LT(upper, 0.89) << "strains are large";
      const double expected = (border * (lower - 1) + (kThick - border) * (upper - 1)) * kVoxel;
      EXPECT_NEAR(pressed_top(model, kPressure) / expected, 1, border % 2 ? 0.02 : 0.01)
          << "border " << border << " energy " << int(energy);
    }
}

/// Region of a law of its own.
TissueLayer region_of(int label, SolidEnergy energy, double young, double poisson, double stiffening) {
  TissueLayer layer = region(label, young, poisson, stiffening);
  layer.energy = energy;
  return layer;
}

/// Three pairs of laws, lower and upper; the pressure strains each by some 8 to 15 %. Their Poisson's ratios
/// are small, because free sides let wide slabs of larger ones yield by some percent more.
std::vector<std::vector<TissueLayer>> mixed_slabs() {
  using enum SolidEnergy;
  return {{region_of(1, kExponential, 5e3, 0.1, 6), region_of(2, kNeoHookean, 3e3, 0.15, 0)},
          {region_of(1, kOgden, 4e3, 0.1, -9), region_of(2, kExponential, 5e3, 0.15, 8)},
          {region_of(1, kNeoHookean, 4e3, 0.15, 0), region_of(2, kOgden, 3e3, 0.05, 8)}};
}

// Two slabs of different kinds of law in one body yield by the sum of both closed forms, whatever the law of
// the body; also where the border runs through the middle of a cell.
TEST(LatticeRegions, SlabsOfTwoKindsOfLawActInSeries) {
  constexpr double kPressure = 500;
  for (const std::vector<TissueLayer>& layers : mixed_slabs())
    for (const int border : {4, 5}) {
      const SolidEnergy of_body = border == 4 ? SolidEnergy::kNeoHookean : *layers[0].energy;
      const Model model = slab_model(SlabCt(border), slab_params(layers, of_body));
      const double lower = confined_stretch(*layers[0].energy, layers[0], kPressure),
                   upper = confined_stretch(*layers[1].energy, layers[1], kPressure);
      const double expected = (border * (lower - 1) + (kThick - border) * (upper - 1)) * kVoxel;
      EXPECT_NEAR(pressed_top(model, kPressure) / expected, 1, border % 2 ? 0.02 : 0.01)
          << "border " << border << " laws " << int(*layers[0].energy) << " " << int(*layers[1].energy);
    }
}

/// A slab of two laws, bent and squeezed at random, with its displacements.
State shaken_state(const Model& model) {
  State state = make_state(model);
  std::uint32_t seed = 7;
  const auto random = [&] { return Real(int((seed = seed * 1664525u + 1013904223u) >> 16) - 32768) / 32768; };
  const Lattice& l = model.anatomy.lattice;
  for (int k = 1; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++)
        state.motion.u.set(std::size_t(node_slot(l, {i, j, k})),
                           Vec3{random(), random(), random()} * (Real(0.12) * l.spacing.x));
  return state;
}

// Kernels in lanes give the force of every cell as the sum of the cell's own law at its corners, where laws
// alternate within a group of cells.
TEST(LatticeRegions, LanesOfMixedLawsAddTheirCells) {
  SlabCt slab(4, 24);
  for_voxels(slab.labels.grid, [&](Int3 p) {
    if (p.z < kThick) slab.labels.at(p.x, p.y, p.z) = std::uint16_t(1 + (p.x / 2 + p.y / 2 + p.z / 2) % 3);
  });
  using enum SolidEnergy;
  Params params = slab_params({region_of(1, kExponential, 6e3, 0.2, 6), region_of(2, kOgden, 3e3, 0.3, -9),
                               region_of(3, kNeoHookean, 5e3, 0.4, 0)},
                              kNeoHookean);
  const Model model = slab_model(slab, params);
  State state = shaken_state(model);
  const Lattice& l = model.anatomy.lattice;
  const CellLawView laws = cell_law_view(model, state);
  const NodeArrays nodes = node_arrays(model, state);
  for (int parity = 0; parity < 2; parity++) {
    // in lanes
    const int slot = row_slot(l, 5, 1) + parity * l.half;
    Real young[kGroup];
    for (int i = 0; i < kGroup; i++) young[i] = i < 5 ? model.anatomy.cell_young[std::size_t(slot + i)] : 0;
    LawCornerForces<kGroup> lanes;
    law_corner_forces(nodes, laws, node_block(l, parity), young, slot, lanes);
    for (int i = 0; i < 5; i++)
      for (int at = 0; at < kCellCorners; at++) {
        // one cell
        const Int3 cell = slot_node(l, slot + i);
        Vec3 d[kCellCorners];
        for (int c = 0; c < kCellCorners; c++)
          d[c] = state.motion.u[std::size_t(node_slot(l, cell + cell_corner(c)))] -
                 state.motion.u[std::size_t(node_slot(l, cell + cell_corner(at)))];
        NodeSystem one{};
        add_viscous_law_cell(one, cell_gradient(d, at, laws.slope), at, laws, slot + i, young[i]);
        const Real scale = norm(one.f);
        EXPECT_NEAR(lanes.x[at][i], one.f.x, 1e-4f * scale);
        EXPECT_NEAR(lanes.y[at][i], one.f.y, 1e-4f * scale);
        EXPECT_NEAR(lanes.z[at][i], one.f.z, 1e-4f * scale);
      }
  }
}

// A body of mixed laws with pairs of their own moves with the same bits on one and four threads, and loses
// the energy with which it was shaken.
TEST(LatticeRegions, MixedLawsKeepTheirBits) {
  std::vector<TissueLayer> layers = mixed_slabs()[1];
  layers[0].prony = one_pair(0.8, 0.3);
  Params params = slab_params(layers, SolidEnergy::kNeoHookean);
  const Model model = slab_model(SlabCt(5, 16), params);
  const auto hash = [&](int threads) {
    State state = shaken_state(model);
    const double before = energy(Exec(1), model, state);
    for (int n = 0; n < 12; n++) step(Exec(threads), model, state, {}, 1.0 / 60);
    EXPECT_LT(energy(Exec(1), model, state), 0.1 * before);
    return state_hash(model, state);
  };
  EXPECT_EQ(hash(1), hash(4));
}

// The part of a cell beside a region keeps the law that it has without regions: that of the body, or of the
// layer by depth.
TEST(LatticeRegions, RestOfCellKeepsItsLaw) {
  const SlabCt slab(5);
  const auto young_at = [&](std::vector<TissueLayer> layers, int k) {
    const Model model = slab_model(slab, slab_params(layers, SolidEnergy::kNeoHookean));
    return double(model.anatomy.cell_young[std::size_t(node_slot(model.anatomy.lattice, {9, 7, k}))]);
  };
  const TissueLayer lower = region(1, 8e3, 0, 0);
  TissueLayer depth{.name = "rest", .young = 2e3};
  EXPECT_NEAR(young_at({depth, lower}, 0), 8e3, 1);
  EXPECT_NEAR(young_at({depth, lower}, 2), 2 / (1 / 8e3 + 1 / 2e3), 1) << "half and half, in series";
  EXPECT_NEAR(young_at({depth, lower}, 3), 2e3, 1);
  // the body's own law: muscle below, the mean of muscle and fat at the surface
  const TissueParams plain;
  EXPECT_NEAR(young_at({lower}, 3), std::sqrt(plain.muscle * plain.fat), 1);
}

// Shares are counts of voxels; the first region wins, air without a label does not count, and a cropped CT
// finds its labels.
TEST(LatticeRegions, SharesAreCountsOfVoxels) {
  SlabCt slab(5);
  TissueLayer dense{.name = "dense", .young = 1e4};
  dense.hu = {150, 200};
  const std::vector<TissueLayer> layers = {region(1, 8e3, 0.2, 0), dense};
  const Params params = slab_params(layers, SolidEnergy::kNeoHookean);
  slab.ct.at(0, 0, 4) = kAirHu, slab.labels.at(0, 0, 4) = 0;
  const auto shares_of = [&](const CtVolume& ct, Int3 cell) {
    std::vector<double> shares(layers.size());
    const Grid nodes = node_grid(ct.grid, params.block);
    for (const RegionShare& one : find_regions(kPair, ct, &slab.labels, params))
      if (one.cell == int(sample_index(nodes, cell.x, cell.y, cell.z)))
        shares[std::size_t(one.layer)] = double(one.share);
    return shares;
  };
  EXPECT_EQ(shares_of(slab.ct, {3, 4, 1}), (std::vector<double>{1, 0}));
  EXPECT_EQ(shares_of(slab.ct, {3, 4, 2}), (std::vector<double>{0.5, 0.5}));
  EXPECT_NEAR(shares_of(slab.ct, {0, 0, 2})[0], 3.0 / 7, 1e-6) << "one of eight voxels is air";
  EXPECT_EQ(shares_of(slab.ct, {3, 4, 3}), (std::vector<double>{0, 1}));
  // without the lowest voxel layer
  CtVolume cropped;
  cropped.grid = slab.ct.grid;
  cropped.grid.size.z--, cropped.grid.origin = point_at(slab.ct.grid, {0, 0, 1});
  cropped.samples.assign(slab.ct.samples.begin() + kWide * kWide, slab.ct.samples.end());
  EXPECT_EQ(shares_of(cropped, {3, 4, 1}), (std::vector<double>{1, 0}));
  EXPECT_EQ(shares_of(cropped, {3, 4, 2}), (std::vector<double>{0, 1}));
}

/// Strain of a body with one pair t seconds after a stress begins, over the static strain.
///     ε = 1 − p/(1 + p) exp(−t/((1 + p) τ))
double creep_of_pair(PronyPair pair, double t) {
  return 1 - pair.ratio / (1 + pair.ratio) * std::exp(-t / ((1 + pair.ratio) * pair.time));
}

// Slabs with relaxation of their own creep in series, each by its closed form; one of them is elastic.
TEST(LatticeRegions, SlabsRelaxByTheirOwnPairs) {
  constexpr double kPressure = 20, kStep = 1.0 / 120;
  for (const bool elastic : {false, true}) {
    std::vector<TissueLayer> layers = {region(1, 6e3, 0, 0), region(2, 3e3, 0, 0)};
    const PronyPair slow{0.5, 1.2}, fast{1.5, 0.15};
    layers[0].prony = one_pair(slow.ratio, slow.time);
    if (elastic) layers[0].prony = Prony{};
    Params params = slab_params(layers, SolidEnergy::kNeoHookean);
    params.tissue.prony = one_pair(fast.ratio, fast.time);  // of the other slab
    params.solver.damping = 60;
    const Model model = slab_model(SlabCt(4, 8), params);
    const Lattice& l = model.anatomy.lattice;
    std::vector<NodeLoad> loads;
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const double share =
            (i == 0 || i == l.size.x - 1 ? 0.5 : 1) * (j == 0 || j == l.size.y - 1 ? 0.5 : 1);
        loads.push_back({node_slot(l, {i, j, 4}), {0, 0, Real(-kPressure * share * 4e-6)}});
      }
    std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
    State state = make_state(model);
    const double lower = kPressure / 6e3 * 0.004, upper = kPressure / 3e3 * 0.004;
    for (int n = 1; n <= 120; n++) {
      step(kPair, model, state, {.loads = loads}, kStep);
      if (n != 30 && n != 120) continue;
      const double t = n * kStep;
      const double expected = lower * (elastic ? 1 : creep_of_pair(slow, t)) + upper * creep_of_pair(fast, t);
      EXPECT_NEAR(-double(state.motion.u[std::size_t(node_slot(l, {2, 2, 4}))].z) / expected, 1, 0.02)
          << t << " s, elastic " << elastic;
    }
  }
}

}  // namespace
}  // namespace turgor::lattice
