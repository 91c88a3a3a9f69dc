// Presses on bodies with partial cells, compared with whole cells on a fine lattice.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/contact/local_contact.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {
namespace {

constexpr int kSide = 36;  // of the layer [voxels]
constexpr double kVoxel = 1e-3, kRadius = 0.012, kFrame = 1.0 / 60;

/// A layer of tissue on a fixed bottom, pressed by a sphere from above.
struct PressedLayer {
  CtVolume ct;
  lattice::Model model;
  lattice::State state;
  LatticeTouch touch, on_nodes;
  std::vector<Tool> tools{{Sphere{kRadius}, 0.3}};
  std::vector<ToolPose> at;
  std::vector<ToolForce> forces{1};
  lattice::BodySurface wounded;  // surface after the cut
  double top = 0;
  Vec3d above;

  PressedLayer(int thickness, int block, bool partial, bool with_skin) {
    ct.grid = {.size = {kSide, kSide, 24}, .spacing = {kVoxel, kVoxel, kVoxel}};
    for (int k = 0; k < 24; k++)
      for (int n = 0; n < kSide * kSide; n++)
        ct.samples.push_back(k < thickness ? std::int16_t(0) : std::int16_t(-1000));
    lattice::Params params;
    params.block = {block, block, block};
    params.fix_ends = true;
    params.skin.enabled = with_skin;
    params.tissue.law = lattice::TissueLaw::kSolid;
    params.tissue.partial_cells = partial;
    params.tissue.fat = params.tissue.muscle = 2e4;
    params.solver = {.sweeps = 12, .damping = 10};
    model = lattice::build(Exec(2), ct, lattice::BodyFields{}, params).value();
    state = lattice::make_state(model);
    const lattice::BodySurface surface =
        lattice::build_surface(model, state.cuts, &ct, lattice::Extent::kAll, Exec(2));
    for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
    // patient frame: the first voxel is at 0
    const Vec3d origin = model.anatomy.grid.origin;
    above = {0.5 * (kSide - 1) * kVoxel, 0.5 * (kSide - 1) * kVoxel, origin.z + top + kRadius};
    at = {{{above, {}}, false}};
    touch = make_lattice_touch(model, state.cuts, surface, at);
    on_nodes = make_lattice_touch(model, state.cuts, surface, at, TouchCarrier::kNodes);
  }
  void carry_by_nodes() { touch = on_nodes; }
  /// Cuts the layer through its middle, 7 mm deep, and waits; after 20 frames the wound is open.
  void cut(const Exec& exec = Exec(2), int frames = 20) {
    const Vec3d middle = above - Vec3d{0, -0.0003, kRadius}, reach{0.01, 0, 0};
    const lattice::BladePath path =
        lattice::lay_blade(model, state, {.from = middle - reach, .to = middle + reach, .depth = 0.007})
            .value();
    lattice::cut_edges(model, state, path, 0, 1, 0);
    wounded = lattice::build_surface(model, state.cuts, &ct, lattice::Extent::kAll, exec);
    for (LatticeTouch* t : {&touch, &on_nodes}) update_surface(*t, model, state.cuts, wounded);
    for (int n = 0; n < frames; n++) lattice::step(exec, model, state, {}, kFrame);
  }
  /// Force after a press to a depth, and a hold of as many frames [N].
  double press(double depth, int frames, const Exec& exec = Exec(2)) {
    for (int n = 0; n < 2 * frames; n++) {
      at[0].pose.position = above - Vec3d{0, 0, depth * std::min(1.0, double(n + 1) / frames)};
      EXPECT_TRUE(step_with_tools(exec, model, state, touch, tools, at, {}, kFrame, forces).finite);
    }
    return forces[0].force.z;
  }
};

// A press has the force of whole cells on a lattice twice as fine, wherever the surface lies between nodes.
TEST(PartialCellTouch, PressMatchesFineLattice) {
  for (const bool with_skin : {false, true})
    for (const int thickness : {with_skin ? 18 : 17}) {
      PressedLayer fine(thickness, 1, false, with_skin), partial(thickness, 2, true, with_skin);
      const double expected = fine.press(0.0025, 15), force = partial.press(0.0025, 15);
      std::printf("%d mm%s: %.4f N, %.3f times the fine lattice's %.4f N; %d contacts\n", thickness,
                  with_skin ? " with skin" : "", force, force / expected, expected,
                  partial.forces[0].contacts);
      EXPECT_NEAR(force, expected, 0.03 * expected) << "N";
      EXPECT_LT(partial.forces[0].largest_penetration, 2e-5) << "m";
      EXPECT_LT(std::hypot(partial.forces[0].force.x, partial.forces[0].force.y), 0.02 * force) << "N";
    }
}

// A press into a wound meets its lips: without samples on them, cells of 4 mm lack 29 % of the force.
TEST(PartialCellTouch, PressIntoWoundMatchesFineLattice) {
  const auto press = [](int block) {
    PressedLayer layer(18, block, true, true);
    layer.cut();
    return layer.press(0.0025, 15);
  };
  const double fine = press(1);
  for (const int block : {4, 2}) {
    const double force = press(block);
    std::printf("%d mm: %.4f N, %.3f times the fine lattice's\n", block, force, force / fine);
    EXPECT_NEAR(force, fine, 0.02 * block * fine) << "N";
  }
}

// Contacts on nodes, as on a device, are stiffer: the test above can fail.
TEST(PartialCellTouch, ContactsOnNodesAreStiffer) {
  PressedLayer in_cells(11, 4, true, true), on_nodes(11, 4, true, true);
  on_nodes.carry_by_nodes();
  EXPECT_GT(on_nodes.press(0.002, 10), 1.03 * in_cells.press(0.002, 10));
}

// Points far from a cut are kept when the surface changes: they are those of samples without known points.
TEST(PartialCellTouch, KeptPointsEqualNewPoints) {
  PressedLayer layer(12, 2, true, true);
  const std::vector<std::uint8_t> before = layer.touch.is_far;
  layer.cut(Exec(2), 0);
  LatticeTouch kept = layer.touch, made = layer.touch;
  EXPECT_EQ(std::set<int>(before.begin(), before.end()).count(1), 1u);
  const auto count = [](const LatticeTouch& t) { return std::count(t.is_far.begin(), t.is_far.end(), 1); };
  EXPECT_GT(count(kept), std::ptrdiff_t(kept.points.size() / 8));
  EXPECT_LT(count(kept), std::count(before.begin(), before.end(), 1));
  made.is_far.clear();  // nothing is known
  for (LatticeTouch* touch : {&kept, &made})
    update_surface(*touch, layer.model, layer.state.cuts, layer.wounded);
  EXPECT_EQ(kept.points, made.points);
  EXPECT_EQ(kept.is_far, made.is_far);
}

// The result does not depend on the number of threads, and the force of the tool is that of its contacts.
TEST(PartialCellTouch, ThreadsGiveSameBits) {
  std::uint64_t hash = 0;
  for (const int threads : {1, 2, 8}) {
    PressedLayer layer(12, 2, true, true);
    layer.cut(Exec(threads), 4);
    EXPECT_GT(layer.press(0.002, 4, Exec(threads)), 0.1) << "N";
    const std::uint64_t now = lattice::state_hash(layer.model, layer.state);
    EXPECT_EQ(now, threads == 1 ? now : hash);
    hash = now;
  }
}

/// Largest distance of a wall sample from the mean of the drawn wall around its node [m].
double off_the_wall(const PressedLayer& layer, const LatticeTouch& touch) {
  const lattice::BodySurface& surface = layer.wounded;
  const auto first = std::size_t(surface.skin_triangles);
  double most = 0;
  int samples = 0;
  for (int p = 0; p < int(touch.samples.size()); p++) {
    if (!touch.samples[std::size_t(p)].wall) continue;
    std::set<int> vertices;
    for (std::size_t t = first; t < surface.triangles.size(); t++)
      for (int c = 0; c < 3; c++)
        if (surface.slot[std::size_t(surface.triangles[t][c])] == touch.samples[std::size_t(p)].slot)
          vertices.insert(surface.triangles[t][c]);
    Vec3d sum;
    for (const int v : vertices)
      sum += Vec3d(surface.rest[std::size_t(v)] + vertex_displacement(layer.model, layer.state, surface, v));
    most =
        std::max(most, norm(sample_position(touch, layer.state.motion, p) - sum / double(vertices.size())));
    samples++;
  }
  EXPECT_GT(samples, 20);
  return most;
}

// Samples on the walls of a wound lie near the drawn wall, those that move with nodes do not.
TEST(PartialCellTouch, WallSamplesLieOnDrawnWall) {
  PressedLayer layer(18, 2, true, true);
  layer.cut();
  const double in_cells = off_the_wall(layer, layer.touch), on_nodes = off_the_wall(layer, layer.on_nodes);
  std::printf("%.3f mm off, on nodes %.3f mm\n", in_cells * 1e3, on_nodes * 1e3);
  EXPECT_LT(in_cells, 4e-4) << "m";
  EXPECT_GT(on_nodes, 2 * in_cells) << "m";
}

// The first stiffness for the haptic thread is an estimate from above, nearer than with whole cells.
TEST(PartialCellTouch, LocalStiffnessMatchesPress) {
  const auto relative = [](bool partial) {
    PressedLayer layer(12, 2, partial, true);
    const double before = layer.press(0.002, 10);
    LocalContactHistory history;
    const LocalContact contact =
        local_contact(layer.model, layer.state.motion, layer.touch, 0, layer.tools[0], layer.at[0], history);
    return contact.stiffness * 0.0002 / (layer.press(0.0022, 10) - before);
  };
  const double in_cells = relative(true), whole = relative(false);
  std::printf("%.2f of a press, whole cells %.2f\n", in_cells, whole);
  EXPECT_GT(in_cells, 0.5);
  EXPECT_LT(in_cells, whole);
}

}  // namespace
}  // namespace turgor::contact
