#include "turgor/models/lattice/mechanics/patch_modes.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/solver/energy.hpp"

namespace turgor::lattice {
namespace {

/// A tilted slab whose cells have random displacements.
struct TiltedSlab {
  Model model;
  State state;

  explicit TiltedSlab(SkinParams skin = {.tension_across = 20}, float amplitude = 4e-4f) {
    CtVolume ct = make_ct({32, 32, 32}, [](Vec3d p) {
      return std::abs((p.x - 16) * 0.7 + (p.y - 15) * 0.2 + (p.z - 16) * 0.5) < 7 && p.x > 3 && p.y > 3 &&
             p.z > 3 && p.x < 28 && p.y < 28 && p.z < 28;
    });
    Params params;
    params.block = {4, 4, 4};
    params.tissue.law = TissueLaw::kSolid;
    params.tissue.partial_cells = true;
    params.skin = skin;
    model = build(Exec(1), ct, BodyFields{}, params).value();
    state = make_state(model);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> value(-amplitude, amplitude);
    for (int s = 0; s < slot_count(model.anatomy.lattice); s++)
      if (has_node(model, s))
        state.motion.u.set(std::size_t(s), {value(random), value(random), value(random)});
  }

  /// Sum of the systems of all corners of patches, by index of the skin node: in lanes, or one by one.
  std::vector<NodeSystem> gather(bool in_lanes) {
    const SkinForces forces(model);
    const NodeArrays nodes = node_arrays(model, state);
    const Skin& skin = model.anatomy.skin;
    const VbdTables& vbd = model.vbd;
    std::vector<NodeSystem> sums(skin.nodes.size());
    CornerSystems lanes;
    for (std::size_t row = 0; row + 1 < skin.row_begin.size(); row++) {
      const int first = vbd.corner_begin[std::size_t(skin.row_begin[row])];
      for (int at = skin.row_begin[row]; at < skin.row_begin[row + 1]; at++)
        for (int c = vbd.corner_begin[std::size_t(at)]; c < vbd.corner_begin[std::size_t(at) + 1]; c++) {
          const int lane = (c - first) % kSkinLanes;
          const PatchCorners& corners =
              vbd.patch_corners[std::size_t(vbd.lanes_begin[row] + (c - first) / kSkinLanes)];
          if (in_lanes) forces.gather(corners, nodes, lanes);
          add(sums[std::size_t(at)], in_lanes ? lanes.get(lane) : forces.gather(corners, lane, nodes));
        }
    }
    return sums;
  }
};

// Lanes of a CPU and threads of a GPU have the same systems.
TEST(LatticePatchModes, LanesMatchSingleCorners) {
  TiltedSlab slab;
  const std::vector<NodeSystem> lanes = slab.gather(true), single = slab.gather(false);
  ASSERT_GT(lanes.size(), 100u);
  for (std::size_t n = 0; n < lanes.size(); n++) {
    EXPECT_LT(norm(lanes[n].f - single[n].f), 1e-5f);
    EXPECT_NEAR(lanes[n].xx, single[n].xx, 1e-4f * (1 + single[n].xx));
    EXPECT_NEAR(lanes[n].yz, single[n].yz, 1e-4f * (1 + std::abs(single[n].xx)));
  }
}

// Forces of cells and patches are the derivative of the energy.
TEST(LatticePatchModes, ForcesMatchEnergyDerivative) {
  TiltedSlab slab;
  const std::vector<NodeSystem> skin = slab.gather(true);
  const Model& model = slab.model;
  const SolidRow solid(model, slab.state);
  for (std::size_t n = 0; n < skin.size(); n += 11) {
    const int slot = model.anatomy.skin.nodes[n];
    if (!(model.anatomy.inverse_mass[std::size_t(slot)] > 0)) continue;
    // forces
    SystemBuffer cells;
    const int group = slot / kGroup * kGroup;
    solid.gather(slot / model.anatomy.lattice.half & 1, group, kGroup, cells);
    const Vec3d force(cells.get(slot - group).f + skin[n].f - model.prestress_force[n]);
    // derivative
    Vec3d slope;
    for (int axis = 0; axis < 3; axis++) {
      double energies[2];
      constexpr float kStep = 2e-5f;
      for (const int side : {0, 1}) {
        State moved = slab.state;
        Vec3 u = moved.motion.u[std::size_t(slot)];
        u[axis] += side ? kStep : -kStep;
        moved.motion.u.set(std::size_t(slot), u);
        energies[side] = energy(Exec(1), model, moved);
      }
      slope[axis] = (energies[1] - energies[0]) / (2 * double(kStep));
    }
    EXPECT_LT(norm(force + slope), 1e-3 * (norm(slope) + 0.01)) << "N";
  }
}

// A Newton step of a corner lowers the energy of skin: its Hessian is at least half the derivative of
// the force in every direction, also in cells that are twisted by half their size.
TEST(LatticePatchModes, HessianBoundsForceDerivative) {
  TiltedSlab slab({.stiffness = 400, .shear = 200, .amplification = 0}, 2e-3f);
  const SkinForces forces(slab.model);
  const Lattice& l = slab.model.anatomy.lattice;
  const NodeArrays nodes = node_arrays(slab.model, slab.state);
  const std::span<const SkinPatch> patches = slab.model.anatomy.skin.patches;
  constexpr Real kStep = 1e-5f;
  std::mt19937 random(5);
  std::normal_distribution<float> any;
  double largest = 0;
  for (std::size_t p = 0; p < patches.size(); p += 5) {
    const int parity = slot_node(l, patches[p].cell).x & 1;
    Vec3 d[kCellCorners];
    for (int c = 0; c < kCellCorners; c++)
      d[c] = nodes.u(patches[p].cell + forces.offset.of[parity][c]) - nodes.u(patches[p].cell);
    for (int c = 0; c < kCellCorners; c++) {
      const NodeSystem s = forces.patch_system(d, c, patches[p]);
      for (int n = 0; n < 10; n++) {
        const Vec3 v = normalized(Vec3{any(random), any(random), any(random)});
        Vec3 force[2];
        for (const int side : {0, 1}) {
          Vec3 moved[kCellCorners];
          std::copy(std::begin(d), std::end(d), std::begin(moved));
          moved[c] += v * (side ? kStep : -kStep);
          force[side] = forces.patch_system(moved, c, patches[p]).f;
        }
        const double slope = double(dot(force[0] - force[1], v)) / (2 * double(kStep));
        const Vec3 h{s.xx * v.x + s.xy * v.y + s.xz * v.z, s.xy * v.x + s.yy * v.y + s.yz * v.z,
                     s.xz * v.x + s.yz * v.y + s.zz * v.z};
        EXPECT_GT(double(dot(h, v)), 0.5 * slope - 0.05) << "N/m";
        largest = std::max(largest, slope);
      }
    }
  }
  EXPECT_GT(largest, 100) << "N/m";
}

// The forces on all corners of a patch, for the coarse correction, are those of its systems.
TEST(LatticePatchModes, ForcesOfPatchesMatchSystems) {
  TiltedSlab slab;
  const SkinForces forces(slab.model);
  const NodeArrays nodes = node_arrays(slab.model, slab.state);
  const std::span<const SkinPatch> patches = slab.model.anatomy.skin.patches;
  const Lattice& l = slab.model.anatomy.lattice;
  for (std::size_t first = 0; first < patches.size(); first += kSkinLanes) {
    const std::size_t count = std::min(patches.size() - first, std::size_t(kSkinLanes));
    PatchForces all;
    forces.compute_forces(patches.subspan(first, count), l, nodes, all);
    for (std::size_t i = 0; i < count; i++) {
      const SkinPatch& patch = patches[first + i];
      const int parity = slot_node(l, patch.cell).x & 1;
      Vec3 d[kCellCorners];
      for (int c = 0; c < kCellCorners; c++) d[c] = nodes.u(patch.cell + forces.offset.of[parity][c]);
      for (int c = 0; c < kCellCorners; c++)
        EXPECT_LT(norm(all.get(c, int(i)) - forces.patch_system(d, c, patch).f), 1e-5f);
    }
  }
}

}  // namespace
}  // namespace turgor::lattice
