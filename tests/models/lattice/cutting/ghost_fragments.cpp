// Ghost fragments: where a cell has no tissue on one side of a blade, its samples follow that side, in
// drawing and in the deformed CT.
#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

/// A tense ball of 1 mm voxels with a straight open cut across its top.
struct OpenBall {
  CtVolume ct = ball_ct(41, 16.3);
  Model model;
  State state;
  BladePath path;

  explicit OpenBall(Vec3d across) {
    Params params;
    params.block = {3, 3, 3};
    params.tissue.law = TissueLaw::kSolid, params.tissue.poisson = 0.45;
    model = build(Exec(2), ct, {}, params).value();
    state = make_state(model);
    const Vec3d line = normalized(cross(across, Vec3d{0, 0, 1})) * 9.0;
    const auto on_skin = [&](Vec3d p) { return ct.grid.origin + (Vec3d{20, 20, 36} + p) * kVoxel; };
    path = lay_blade(model, state, {.from = on_skin(-line), .to = on_skin(line), .depth = 0.008}).value();
    cut_edges(model, state, path, 0, 1, 0);
    for (int n = 0; n < 30; n++) step(Exec(2), model, state, {}, 1.0 / 60);
  }
  /// Signed distance of a CT position to the right of the blade, lattice frame [m].
  double right_of_blade(Vec3d x) const {
    const std::size_t n = path.points.size() / 2;
    return dot(x - path.points[n], across_at(path, n));
  }
};

constexpr double kLip = 0.25 * kVoxel;  // closer to the blade, either side is accepted [m]
const Vec3d kAcross[] = {{0, 1, 0}, {0.3, 1, 0}, {1, 0.8, 0}};

// The samples of a ghost fragment lie on the same side of the blade as its fragment.
TEST(GhostFragments, SamplesLieOnTheirSide) {
  int ghosts = 0;
  for (const Vec3d across : kAcross) {
    const OpenBall ball(across);
    const Fragments fragments = make_fragments(ball.model, ball.state.cuts);
    const FineLattice& f = fragments.fine;
    const Vec3d step(f.cells.spacing);
    const auto side_of = [&](Int3 node) {
      return ball.right_of_blade(hadamard(lattice_index(f, node), step));
    };
    for (const CutCell& cell : fragments.cells) {
      const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
      if (cell.ghost_count == 0) continue;
      for_sub_nodes(f, [&](Int3 p) {
        const int fragment = fragment_of(fragments.label.data(), cell, sub_index(f, p));
        if (fragment < cell.fragment_count) return;
        const GhostFragment& ghost =
            fragments.ghosts[std::size_t(cell.first_ghost + fragment - cell.fragment_count)];
        const CutCell& home = fragments.cells[std::size_t(ghost.cell)];
        const Int3 home_first = first_of_cell(f, slot_node(f.cells, home.slot));
        for_sub_nodes(f, [&](Int3 q) {
          if (fragments.label[home.first_sub_index + std::size_t(sub_index(f, q))] != ghost.fragment) return;
          EXPECT_GT(side_of(first + p) * side_of(home_first + q), 0);
        });
        ghosts++;
      });
    }
  }
  EXPECT_GT(ghosts, 20);
}

// In the deformed CT, every voxel beside a wound moves with its own side.
TEST(GhostFragments, VoxelsMoveWithTheirSide) {
  for (const Vec3d across : kAcross) {
    const OpenBall ball(across);
    const Wound wound = measure_wound(ball.model, ball.state, ball.path, 0);
    ASSERT_GT(wound.gape_max, 2e-3);
    const VectorVolume back =
        resample_displacement(Exec(2), ball.model, ball.state, resized(ball.ct.grid, ball.ct.grid.size * 2));
    const Mat3d to_lattice = inverse(ball.model.anatomy.grid.axes);
    const std::size_t middle = ball.path.points.size() / 2;
    int examined = 0, wrong = 0;
    for (int k = 0; k < back.grid.size.z; k++)
      for (int j = 0; j < back.grid.size.y; j++)
        for (int i = 0; i < back.grid.size.x; i++) {
          const Vec3d d(back.samples[sample_index(back.grid, i, j, k)]);
          if (norm(d) == 0) continue;
          const Vec3d now = to_lattice *
                            (point_at(back.grid, Vec3d(Int3{i, j, k})) - ball.model.anatomy.grid.origin),
                      moved = -(to_lattice * d), rest = now - moved;
          const Vec3d from_middle = rest - ball.path.points[middle];
          const double aside = ball.right_of_blade(rest);
          if (norm(from_middle) > 7e-3 || std::abs(aside) > 3e-3 || std::abs(aside) < kLip) continue;
          examined++;
          wrong += dot(moved, across_at(ball.path, middle)) * aside < -0.3e-3 * std::abs(aside);
        }
    std::printf("  a wound of %.1f mm: %d voxels beside it, %d move with the other side\n",
                wound.gape_max * 1e3, examined, wrong);
    EXPECT_GT(examined, 50);
    EXPECT_EQ(wrong, 0);
  }
}

}  // namespace
}  // namespace turgor::lattice
