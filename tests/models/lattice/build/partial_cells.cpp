#include "turgor/models/lattice/build/partial_cells.hpp"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/bar_scan.hpp"
#include "turgor/models/lattice/cutting/cut_topology.hpp"
#include "turgor/models/lattice/cutting/loose_rim.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/moving_mass.hpp"
#include "turgor/models/lattice/solver/energy.hpp"

namespace turgor::lattice {
namespace {

/// `clamped`: nodes within one and a half steps of the ends are fixed.
Model bar_model(const Scan& scan, int block, bool partial = true, bool clamped = false) {
  return make_bar_model(scan, block, partial, [&](Vec3d at) {
    return clamped && std::abs(at.z) > 0.5 * scan.bar.length - 1.5 * block * kVoxel;
  });
}

/// Energy of a displacement that is prescribed at fixed nodes and initial elsewhere, in the bar's axes, after
/// `steps` steps of 1/60 s [J].
template <class Displacement>
double energy_of(const Model& model, const Bar& bar, int steps, const Displacement& displacement) {
  State state = make_state(model);
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++) {
    const Int3 node = slot_node(model.anatomy.lattice, s);
    if (!contains(model.anatomy.lattice, node) || node_slot(model.anatomy.lattice, node) != s) continue;
    const Vec3d u = displacement(
        bar.local(Vec3d(rest_position(model.anatomy.lattice, slot_node(model.anatomy.lattice, s)))));
    state.motion.u.set(std::size_t(s), Vec3(bar.axes * u));
  }
  for (int n = 0; n < steps; n++) step(kExec, model, state, {}, 1.0 / 60);
  return energy(kExec, model, state);
}

struct Stiffness {
  double axial, bend;  // relative to the bar's
};
/// Energies of uniaxial tension and of pure bending, whose exact fields leave the sides free of load.
Stiffness stiffness_of(const Model& model, const Bar& bar, int steps = 0) {
  constexpr double kStrain = 1e-4;
  const double tension = energy_of(model, bar, steps, [](Vec3d p) {
    return Vec3d{-kPoisson * p.x, -kPoisson * p.y, p.z} * kStrain;
  });
  const double curvature = 2 * kStrain / bar.side;
  const double bending = energy_of(model, bar, steps, [&](Vec3d p) {
    return Vec3d{-kPoisson * p.x * p.y, -0.5 * p.z * p.z - 0.5 * kPoisson * (p.y * p.y - p.x * p.x),
                 p.z * p.y} *
           curvature;
  });
  const double inertia = std::pow(bar.side, 4) / 12;
  return {tension / (0.5 * kYoung * kStrain * kStrain * bar.volume()),
          bending / (0.5 * kYoung * inertia * curvature * curvature * bar.length)};
}

const std::array<Vec3d, 6> kDirections = {
    {{0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0.3, 0.2, 0.93}, {1, 1, 1}, {-0.5, 0.7, 0.4}}};

// A bar of four or eight steps is as stiff as in theory, in any direction and wherever it lies between the
// nodes.
TEST(LatticePartialCells, BarsMatchTheoryInAnyDirection) {
  for (const int block : {4, 2}) {
    const double tolerance = block == 4 ? 0.10 : 0.05;
    int tenth = 0;
    for (const Vec3d direction : kDirections) {
      const Vec3d offset = Vec3d{0.1, 0.3, 0.7} * double(tenth++);
      const Scan scan =
          scan_bar(16, 64, block, direction, 0.3 * tenth, offset - Vec3d{1, 1, 1} * std::floor(offset.x));
      const Stiffness found = stiffness_of(bar_model(scan, block, true, true), scan.bar, 10);
      EXPECT_NEAR(found.axial, 1, tolerance) << "block " << block << ", direction " << tenth;
      EXPECT_NEAR(found.bend, 1, tolerance) << "block " << block << ", direction " << tenth;
    }
  }
}

// Along the axes the stiffness does not depend on the position between the nodes.
TEST(LatticePartialCells, OffsetsInTenthsOfAStepAgree) {
  for (int tenth = 0; tenth < 10; tenth++) {
    const double offset = 0.1 * tenth;
    const Scan scan = scan_bar(16, 64, 4, {0, 0, 1}, 0, {offset, offset, offset});
    const Stiffness found = stiffness_of(bar_model(scan, 4), scan.bar);

    EXPECT_NEAR(found.axial, 1, 0.05) << "offset " << offset;
    EXPECT_NEAR(found.bend, 1, 0.10) << "offset " << offset;
  }
}

// The same bar that ends at its outermost nodes is far too soft: the test above can fail.
TEST(LatticePartialCells, WholeCellsAloneAreTooSoft) {
  const Scan scan = scan_bar(16, 64, 4, {0, 0, 1}, 0, {0.5, 0.5, 0.5});
  EXPECT_LT(stiffness_of(bar_model(scan, 4, false), scan.bar).bend, 0.7);
}

// The mass of the nodes is that of the voxels, for blocks of even and of odd width.
TEST(LatticePartialCells, MassIsThatOfTheVoxels) {
  for (const int block : {1, 2, 3, 4, 5})
    for (const Vec3d direction : {Vec3d{0, 0, 1}, Vec3d{-0.5, 0.7, 0.4}}) {
      const Scan scan = scan_bar(16, 64, block, direction, 0.2, {0.2, 0.6, 0.4});
      double voxels = 0;
      for (const std::int16_t hu : scan.ct.samples) voxels += hu + 1000;
      const double mass = moving_mass(bar_model(scan, block).anatomy);
      EXPECT_NEAR(mass / (voxels * std::pow(kVoxel, 3)), 1, 2e-3) << "block " << block;
    }
}

/// Displacements of a cell's corners from a seed [m].
std::array<Vec3, 8> random_displacements(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<float> value(-0.3f, 0.3f);
  std::array<Vec3, 8> u;
  for (Vec3& d : u) d = {value(random), value(random), value(random)};
  return u;
}

// The forces of a partial cell are the derivatives of its energy.
TEST(LatticePartialCells, ForcesMatchEnergyDerivative) {
  const Vec3 spacing{1, 1.25f, 0.8f};
  const SolidLaw law = solid_law(spacing, kPoisson);
  const CellCenter center = packed_center({0.5, -0.75, 0.3});
  const Vec3 point = center.in_half_cells();
  EXPECT_NEAR(point.x, 0.5, 1.0 / 512);
  EXPECT_NEAR(point.y, -0.75, 1.0 / 512);
  EXPECT_NEAR(point.z, 0.3, 1.0 / 512);
  for (int seed = 0; seed < 5; seed++) {
    const std::array<Vec3, 8> u = random_displacements(seed);
    for (int corner = 0; corner < 8; corner++) {
      // force by both ways
      Vec3 d[8];
      for (std::size_t c = 0; c < 8; c++) d[c] = u[c] - u[std::size_t(corner)];
      NodeSystem s;
      add_cell(s, cell_gradient_at(d, corner, law.slope, point), shape_gradient(corner, law.slope, point),
               law, 1);
      const Vec3 f = corner_force_at(cell_stress_at(d, law, 1, point), d[corner], corner, point);
      // derivative of the energy
      for (int axis = 0; axis < 3; axis++) {
        Vec3d moved[8];
        for (std::size_t c = 0; c < 8; c++) moved[c] = Vec3d(u[c]);
        const double h = 1e-5;
        moved[corner][axis] += h;
        const double above = cell_energy(moved, spacing, kPoisson, Vec3d(point));
        moved[corner][axis] -= 2 * h;
        const double below = cell_energy(moved, spacing, kPoisson, Vec3d(point));
        const double expected = -(above - below) / (2 * h);
        EXPECT_NEAR(s.f[axis], expected, 2e-4 * (1 + std::abs(expected)));
        EXPECT_NEAR(f[axis], expected, 2e-4 * (1 + std::abs(expected)));
      }
    }
  }
}

// A rim node is fixed if the body nodes next to it are.
TEST(LatticePartialCells, RimOfFixedNodesIsFixed) {
  const Scan scan = scan_bar(16, 64, 4, {0, 0, 1}, 0.4, {0.3, 0.1, 0.6});
  const Model model = bar_model(scan, 4, true, true);
  const State state = make_state(model);
  int fixed = 0, free = 0;
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++) {
    const Int3 node = slot_node(model.anatomy.lattice, s);
    if (!contains(model.anatomy.lattice, node) || node_slot(model.anatomy.lattice, node) != s) continue;
    if (is_body(model.anatomy.tissue[std::size_t(s)])) continue;
    bool is_corner = false;
    for (int n = 0; n < kCellCorners; n++)
      is_corner = is_corner || is_whole_cell(model, state.cuts, node - cell_corner(n));
    if (!is_corner) continue;
    const Vec3d at = scan.bar.local(Vec3d(rest_position(model.anatomy.lattice, node)));
    const bool is_fixed = model.anatomy.inverse_mass[std::size_t(s)] == 0;
    // steps from the end of the fixed nodes
    const double beyond = (std::abs(at.z) - 0.5 * scan.bar.length) / (4 * kVoxel) + 1.5;
    if (beyond > 0.8) {
      EXPECT_TRUE(is_fixed);
      fixed++;
    }
    if (beyond < -0.8) {
      EXPECT_FALSE(is_fixed);
      free++;
    }
  }
  EXPECT_GT(fixed, 5);
  EXPECT_GT(free, 10);
}

// A rim node is removed if all cells around it are cut; others stay.
TEST(LatticePartialCells, RimWithoutCellsIsRemoved) {
  const Scan scan = scan_bar(16, 64, 4, {0, 0, 1}, 0, {0.3, 0.1, 0.6});
  const Model model = bar_model(scan, 4);
  State state = make_state(model);
  const int half = model.anatomy.lattice.size.z / 2;
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++)
    if (has_node(model, s) && slot_node(model.anatomy.lattice, s).z >= half) {
      state.cuts.cut[std::size_t(s)] |= 0x7f;
      mark_rows(model, state.cuts, s);
    }
  remove_loose_rim(model, state);
  int removed = 0, kept = 0;
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++) {
    const bool is_removed = state.cuts.removed[std::size_t(s)] != 0;
    if (!is_rim(model, s)) {
      EXPECT_FALSE(is_removed);
      continue;
    }
    const int z = slot_node(model.anatomy.lattice, s).z;
    if (z != half) {
      EXPECT_EQ(is_removed, z > half) << z;
    }
    removed += is_removed, kept += !is_removed;
  }
  EXPECT_GT(removed, 10);
  EXPECT_GT(kept, 10);
}

}  // namespace
}  // namespace turgor::lattice
