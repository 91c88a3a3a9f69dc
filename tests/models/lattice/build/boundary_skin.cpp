// Skin in partial cells (Skin::patches): its area and tension in closed form, its forces against its energy,
// and the gape of one wound wherever the skin lies between the nodes.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/solver/energy.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);
constexpr double kMillimeter = 1e-3;

Params params_with_partial_cells(int block) {
  Params params;
  params.block = {block, block, block};
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.fat = params.tissue.muscle = 5e3;
  params.tissue.partial_cells = true;
  params.solver = {.sweeps = 20, .damping = 8};
  return params;
}

/// CT of a ball of water in air. Voxels at its surface have a mean HU of their part inside.
struct BallScan {
  CtVolume ct;
  Vec3d middle;
  double radius;
};
BallScan scan_ball(double radius, int voxels) {
  BallScan scan{.ct = {}, .middle = {}, .radius = radius};
  scan.ct.grid.size = {voxels, voxels, voxels};
  scan.ct.grid.spacing = {kMillimeter, kMillimeter, kMillimeter};
  scan.middle = Vec3d{0.5 * voxels + 0.3, 0.5 * voxels - 0.4, 0.5 * voxels + 0.1} * kMillimeter;
  for (int k = 0; k < voxels; k++)
    for (int j = 0; j < voxels; j++)
      for (int i = 0; i < voxels; i++) {
        const double beyond = norm(Vec3d{i + 0.0, j + 0.0, k + 0.0} * kMillimeter - scan.middle) - radius;
        scan.ct.samples.push_back(std::int16_t(-1000 * std::clamp(0.5 + beyond / kMillimeter, 0.0, 1.0)));
      }
  return scan;
}
Model ball_model(const BallScan& scan, int block) {
  return build(kTwo, scan.ct, {}, params_with_partial_cells(block)).value();
}

// The patches of a ball have the area of the ball, and lie on it.
TEST(BoundarySkin, BallHasItsArea) {
  const BallScan scan = scan_ball(0.02, 56);
  for (const int block : {2, 3, 4}) {
    const Model model = ball_model(scan, block);
    const double expected = 4 * std::numbers::pi * scan.radius * scan.radius;
    double area = 0;
    for (const SkinPatch& p : model.anatomy.skin.patches) {
      area += double(p.area);
      const Vec3d cell(rest_position(model.anatomy.lattice, slot_node(model.anatomy.lattice, p.cell)));
      const Vec3d at = cell + hadamard(Vec3d(p.point) + Vec3d{1, 1, 1}, model.anatomy.grid.spacing) * 0.5;
      EXPECT_NEAR(norm(point_at(model.anatomy.grid, {}) + at - scan.middle), scan.radius, 0.5 * kMillimeter)
          << "block " << block;
    }
    EXPECT_NEAR(area, expected, 0.03 * expected) << "block " << block;
  }
}

// Laplace: a skin with tension T on a ball does the virtual work −2 T A in a dilation, and pulls its halves
// together with 2 π R T.
TEST(BoundarySkin, BallHasLaplacePressure) {
  const BallScan scan = scan_ball(0.02, 56);
  for (const int block : {2, 4}) {
    const Model model = ball_model(scan, block);
    const double tension = model.params.skin.tension_along;
    double work = 0, pull = 0;
    Vec3d sum;
    const int middle = model.anatomy.lattice.size.z / 2;
    for (std::size_t n = 0; n < model.anatomy.skin.nodes.size(); n++) {
      const Int3 node = slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[n]);
      const Vec3d force(model.prestress_force[n]);
      const Vec3d x = point_at(model.anatomy.grid, Vec3d(node)) - scan.middle;
      work += dot(force, x), sum += force;
      if (node.z > middle) pull -= force.z;
    }
    const double area = 4 * std::numbers::pi * scan.radius * scan.radius;
    EXPECT_NEAR(work, -2 * tension * area, 0.04 * 2 * tension * area) << "block " << block;
    // the plane between the layers is at most half a spacing from the equator
    const double equator = 2 * std::numbers::pi * scan.radius * tension;
    EXPECT_NEAR(pull, equator, 0.04 * equator) << "block " << block;
    EXPECT_LT(norm(sum), 1e-4 * equator);
  }
}

// The forces of a patch are the derivatives of its energy, in every corner.
TEST(BoundarySkin, ForcesMatchEnergyDerivative) {
  const Model model = ball_model(scan_ball(0.012, 40), 4);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-2e-4f, 2e-4f);
  State state = make_state(model);
  const std::vector<SkinPatch>& patches = model.anatomy.skin.patches;
  ASSERT_FALSE(patches.empty());
  const SkinForces forces(model);
  const CellOffsets offset(model.anatomy.lattice);
  for (const std::size_t p : {std::size_t(0), patches.size() / 3, patches.size() / 2}) {
    const int parity = slot_node(model.anatomy.lattice, patches[p].cell).x & 1;
    for (int c = 0; c < kCellCorners; c++)
      state.motion.u.set(std::size_t(patches[p].cell + offset.of[parity][c]),
                         {value(random), value(random), value(random)});
    NodeArrays nodes{};
    nodes.ux = state.motion.u.x.data(), nodes.uy = state.motion.u.y.data(),
    nodes.uz = state.motion.u.z.data();
    PatchForces all;
    forces.compute_forces(std::span(patches).subspan(p, 1), model.anatomy.lattice, nodes, all);
    // energy of this patch alone: all others are marked as cut, and the tissue is subtracted
    const auto patch_energy = [&] {
      std::fill(state.cuts.skin_cut.begin(), state.cuts.skin_cut.end(), std::uint8_t(1));
      const double without = energy(kTwo, model, state);
      state.cuts.skin_cut[p] = 0;
      return energy(kTwo, model, state) - without;
    };
    for (int c = 0; c < kCellCorners; c++) {
      const auto slot = std::size_t(patches[p].cell + offset.of[parity][c]);
      // the same force by the system of the node
      Vec3 d[kCellCorners];
      for (int q = 0; q < kCellCorners; q++)
        d[q] = state.motion.u[std::size_t(patches[p].cell + offset.of[parity][q])] - state.motion.u[slot];
      const Vec3 own = forces.patch_system(d, c, patches[p]).f;
      const Vec3 before = state.motion.u[slot];
      for (int axis = 0; axis < 3; axis++) {
        Vec3 moved = before;
        moved[axis] = before[axis] + 2e-5f;
        state.motion.u.set(slot, moved);
        const double high = moved[axis], above = patch_energy();
        moved[axis] = before[axis] - 2e-5f;
        state.motion.u.set(slot, moved);
        const double expected = -(above - patch_energy()) / (high - double(moved[axis]));
        state.motion.u.set(slot, before);
        EXPECT_NEAR(all.get(c, 0)[axis], expected, 1e-3 * (0.02 + std::abs(expected)));
        EXPECT_NEAR(own[axis], expected, 1e-3 * (0.02 + std::abs(expected)));
      }
    }
  }
}

/// A slab under taut skin, cut along its first axis.
struct Slab {
  int block = 4;
  double offset = 0;               // height of the skin above a node [spacings]
  double tilt = 0, direction = 0;  // of the skin: angle with a face of the lattice, and its azimuth [°]
  bool is_flipped = false;         // stored upside down
  bool has_partial_cells = true;

  static constexpr double kHalf = 24, kDepth = 20;  // free tissue [mm]

  Vec3d normal() const {
    const double t = tilt * std::numbers::pi / 180, d = direction * std::numbers::pi / 180;
    return {std::sin(t) * std::cos(d), std::sin(t) * std::sin(d), std::cos(t)};
  }
  /// A vector or position as it is stored.
  Vec3d stored(Vec3d v) const { return is_flipped ? Vec3d{v.x, v.y, -v.z} : v; }
};

/// Slab in a scan whose voxels at the skin have the mean HU of their part inside. Tissue is free within 24 mm
/// of its middle.
struct SlabBody {
  CtVolume ct;
  Model model;
  Vec3d middle, along, across;
};
SlabBody slab_body(const Slab& slab) {
  const double rise = 1.5 * Slab::kHalf * std::sin(slab.tilt * std::numbers::pi / 180);
  const auto blocks = [&](double length) { return int(std::ceil(length / slab.block)) * slab.block; };
  const int side = blocks(3 * Slab::kHalf) + 4 * slab.block,
            up = blocks(Slab::kDepth + rise) + 3 * slab.block, tall = up + blocks(rise) + 4 * slab.block;
  const Vec3d middle{side / 2.0, side / 2.0 + slab.block, up + slab.offset * slab.block};
  const Vec3d normal = slab.normal(), along = normalized(Vec3d{1, 0, 0} - normal * normal.x),
              across = cross(normal, along);
  SlabBody body{
      .ct = {}, .model = {}, .middle = {}, .along = slab.stored(along), .across = slab.stored(across)};
  CtVolume& ct = body.ct;
  ct.grid.size = {side, side + 2 * slab.block, tall};
  ct.grid.spacing = {kMillimeter, kMillimeter, kMillimeter};
  for (int k = 0; k < tall; k++)
    for (int j = 0; j < ct.grid.size.y; j++)
      for (int i = 0; i < side; i++) {
        const Vec3d at{i + 0.5, j + 0.5, (slab.is_flipped ? tall - 1 - k : k) + 0.5};
        const double filled = std::clamp(0.5 - dot(normal, at - middle), 0.0, 1.0);
        ct.samples.push_back(std::int16_t(std::lround(1000 * filled - 1000)));
      }
  body.middle = ct.grid.origin +
                Vec3d{middle.x - 0.5, middle.y - 0.5, (slab.is_flipped ? tall - middle.z : middle.z) - 0.5} *
                    kMillimeter;
  // lines along the cut, and free tissue
  Params params = params_with_partial_cells(slab.block);
  params.tissue.partial_cells = slab.has_partial_cells;
  params.skin.direction = body.along;
  BodyNodes nodes = classify(kTwo, ct, nullptr, params).value();
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const Vec3d x = slab.stored(point_at(nodes.grid, Vec3d(Int3{i, j, k})) - body.middle) / kMillimeter;
        const double beside = std::max(std::abs(dot(x, along)), std::abs(dot(x, across)));
        nodes.fixed[sample_index(nodes.grid, i, j, k)] =
            beside > Slab::kHalf - 0.5 * slab.block || -dot(x, normal) > Slab::kDepth - 0.5 * slab.block;
      }
  body.model = assemble(kTwo, nodes, nullptr, params).value();
  return body;
}

/// Gape of a cut of 24 mm [m].
double gape_in(const Slab& slab) {
  const SlabBody body = slab_body(slab);
  State state = make_state(body.model);
  const Vec3d at = body.middle + body.across * (0.37 * slab.block * kMillimeter), reach = body.along * 0.012;
  const BladePath path =
      lay_blade(body.model, state, {.from = at - reach, .to = at + reach, .depth = 0.008}).value();
  cut_edges(body.model, state, path, 0, 1, 0);
  for (int n = 0; n < 30; n++) step(kTwo, body.model, state, {}, 1.0 / 30);
  const BodySurface surface = build_surface(body.model, state.cuts, &body.ct, Extent::kCuts);
  return measure_wound(body.model, state, surface, path, 0).gape_max;
}

// A wound gapes alike wherever the skin lies between two nodes, in both storage orders.
TEST(BoundarySkin, GapeDoesNotDependOnThePositionOfTheSkin) {
  double sum = 0, least = 1, most = 0;
  int count = 0;
  for (const double offset : {0.0, 0.2, 0.4, 0.7, 0.9}) {
    const double gape = gape_in({.offset = offset, .is_flipped = count % 2 == 1});
    sum += gape, least = std::min(least, gape), most = std::max(most, gape), count++;
  }
  EXPECT_GT(least, 0.98 * sum / count);
  EXPECT_LT(most, 1.02 * sum / count);
}

// The same at smaller cells, where the body has more of them.
TEST(BoundarySkin, GapeInSmallerCellsDoesNotDependOnThePosition) {
  for (const int block : {3, 2}) {
    double sum = 0, least = 1, most = 0;
    int count = 0;
    for (const double offset : {0.0, 0.35, 0.7})
      for (const bool is_flipped : {false, true}) {
        if (block == 2 && offset == 0.35) continue;  // takes seconds
        const double gape = gape_in({.block = block, .offset = offset, .is_flipped = is_flipped});
        sum += gape, least = std::min(least, gape), most = std::max(most, gape), count++;
      }
    EXPECT_GT(least, 0.98 * sum / count) << "cells of " << block << " voxels";
    EXPECT_LT(most, 1.02 * sum / count) << "cells of " << block << " voxels";
  }
}

// A wound gapes alike wherever the skin leaves a layer of cells, also where the blade is oblique in them. The
// cut is level, since the ends of a cut that is oblique in the lattice move by up to half a cell.
TEST(BoundarySkin, GapeDoesNotDependOnTheTiltOfTheSkin) {
  const double flat = gape_in({.offset = 0.3});
  for (const double tilt : {4.0, 12.0, 23.0}) {
    EXPECT_NEAR(gape_in({.offset = 0.6, .tilt = tilt, .direction = 90}), flat, 0.05 * flat) << tilt << "°";
  }
  for (const double tilt : {17.0, 20.0, 27.0})
    for (const double offset : {0.0, 0.45})
      EXPECT_NEAR(gape_in({.offset = offset, .tilt = tilt, .direction = 90}), flat, 0.07 * flat)
          << tilt << "°, skin " << offset << " cells above a node";
}

/// Skin around the end of an oblique cut that ends `beyond` cells beyond a node.
struct SkinAtEnd {
  double rise = 0;  // range of the skin's rise within 1.5 cells, behind the end [m]
  double gape = 0;  // [m]
};
SkinAtEnd skin_at_end(const Slab& slab, Vec3d line, double beyond) {
  const SlabBody body = slab_body(slab);
  const Grid& grid = body.model.anatomy.grid;
  const double h = grid.spacing.x;
  // the blade, from the middle of the slab to a node
  line = normalized(line);
  Vec3d end = index_at(grid, body.middle + line * 0.006);
  end = point_at(grid, {std::round(end.x), std::round(end.y), end.z});
  State state = make_state(body.model);
  const BladePath path =
      lay_blade(body.model, state,
                {.from = end - line * 0.0155, .to = end + line * (beyond * h), .depth = 0.008})
          .value();
  cut_edges(body.model, state, path, 0, 1, 0);
  for (int n = 0; n < 30; n++) step(kTwo, body.model, state, {}, 1.0 / 30);
  // drawn skin behind the end
  const BodySurface surface = build_surface(body.model, state.cuts, &body.ct);
  SkinAtEnd found;
  found.gape = measure_wound(body.model, state, surface, path, 0).gape_max;
  double low = 1, high = -1;
  const std::vector<Vec3d> rest = rest_points(body.model, surface);
  for (int t = 0; t < surface.skin_triangles; t++)
    for (int c = 0; c < 3; c++) {
      const int v = surface.triangles[std::size_t(t)][c];
      const Vec3d away = rest[std::size_t(v)] - end;
      if (dot(away, line) < 0.1 * h || norm(Vec3d{away.x, away.y, 0}) > 1.5 * h || std::abs(away.z) > h)
        continue;
      const double rise = double(vertex_displacement(body.model, state, surface, v).z);
      low = std::min(low, rise), high = std::max(high, rise);
    }
  found.rise = high - low;
  return found;
}

// The skin behind a cut that ends at a node, or a little beyond it, does not bulge, and the cut gapes as one
// that ends before the node. The copies of the node on both sides of the blade are held by the cell behind
// it.
TEST(BoundarySkin, SkinDoesNotBulgeBehindEndAtNode) {
  const Slab slab{.block = 3, .offset = 0.3};
  for (const Vec3d line : {Vec3d{1, 1, 0}, {1, 0, 0}, {-1, 2, 0}}) {
    const SkinAtEnd before = skin_at_end(slab, line, -0.1);
    for (const double beyond : {0.0, 0.03}) {
      const SkinAtEnd skin = skin_at_end(slab, line, beyond);
      EXPECT_LT(skin.rise, 0.05 * slab.block * kMillimeter) << "m, along " << line.x << " " << line.y;
      EXPECT_NEAR(skin.gape, before.gape, 0.03 * before.gape) << "m, along " << line.x << " " << line.y;
    }
  }
}

// A piece leaves with its rim nodes: nothing that is left moves.
TEST(BoundarySkin, ExcisedWoundComesToRest) {
  const SlabBody body = slab_body({.offset = 0.4, .tilt = 12, .direction = 90});
  State state = make_state(body.model);
  Incision blade{.name = "lens", .depth = 0.0067};
  blade.excision = Excision{.center = body.middle, .direction = body.along, .length = 0.02, .width = 0.012};
  blade.path = excision_outline(body.model, state, *blade.excision).value();
  const BladePath path = lay_blade(body.model, state, blade).value();
  cut_edges(body.model, state, path, 0, 1, 0);
  excise(body.model, state, find_piece(body.model, state.cuts, 0).value());
  for (int n = 0; n < 30; n++) step(kTwo, body.model, state, {}, 1.0 / 30);
  EXPECT_LT(state.motion.fastest, 1e-4f) << "m/s";
}

// The tension of tilted skin is in balance at every node: the patches of neighbor cells close.
TEST(BoundarySkin, TiltedSkinLeavesNoForces) {
  for (const double direction : {20.0, 75.0}) {
    const SlabBody body = slab_body({.offset = 0.3, .tilt = 14, .direction = direction});
    const Model& model = body.model;
    for (std::size_t n = 0; n < model.anatomy.skin.nodes.size(); n++) {
      const Int3 node = slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[n]);
      const Vec3d x = point_at(model.anatomy.grid, Vec3d(node)) - body.middle;
      if (norm(x) > 0.02) continue;
      EXPECT_LT(norm(model.prestress_force[n]), 0.05 * model.params.skin.tension_along * 4 * kMillimeter);
    }
  }
}

}  // namespace
}  // namespace turgor::lattice
