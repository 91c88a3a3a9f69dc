// Where a cell has no tissue on one side of a blade: what lies there goes with that side, drawn and in the
// deformed CT.
#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

/// A tense ball of 1 mm voxels with a straight cut across its top, open.
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
  /// How far to the right of the blade a place in the CT is, lattice frame [m].
  double right_of_blade(Vec3d x) const {
    const std::size_t n = path.skin.size() / 2;
    return dot(x - path.skin[n], across_at(path, n));
  }
};

constexpr double kLip = 0.25 * kVoxel;  // nearer to the blade than this either side will do [m]
const Vec3d kAcross[] = {{0, 1, 0}, {0.3, 1, 0}, {1, 0.8, 0}};

TEST(lattice_ghosts, what_a_piece_or_a_ghost_carries_lies_on_its_own_side_of_the_blade) {
  int ghosts = 0;
  for (const Vec3d across : kAcross) {
    const OpenBall ball(across);
    const Fragments pieces = make_fragments(ball.model, ball.state);
    const FineLattice& f = pieces.fine;
    const Vec3d step(f.cells.step);
    const auto side_of = [&](Int3 node) {
      return ball.right_of_blade(hadamard(lattice_index(f, node), step));
    };
    for (const CutCell& cell : pieces.cells) {
      const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
      if (cell.ghost_count == 0) continue;
      for_places(f, [&](Int3 p) {
        const int piece = piece_of(pieces.label.data(), cell, place_in_cell(f, p));
        if (piece < cell.fragment_count) return;
        const GhostFragment& ghost =
            pieces.ghosts[std::size_t(cell.first_ghost + piece - cell.fragment_count)];
        const CutCell& home = pieces.cells[std::size_t(ghost.cell)];
        const Int3 home_first = first_of_cell(f, slot_node(f.cells, home.slot));
        for_places(f, [&](Int3 q) {
          if (pieces.label[home.places + std::size_t(place_in_cell(f, q))] != ghost.piece) return;
          EXPECT_GT(side_of(first + p) * side_of(home_first + q), 0);
        });
        ghosts++;
      });
    }
  }
  EXPECT_GT(ghosts, 20);
}

TEST(lattice_ghosts, every_voxel_of_the_deformed_ct_beside_a_wound_comes_from_its_own_side) {
  for (const Vec3d across : kAcross) {
    const OpenBall ball(across);
    const Wound wound = measure_wound(ball.model, ball.state, ball.path, 0);
    ASSERT_GT(wound.gape_max, 2e-3);
    const VectorVolume back =
        resample_displacement(Exec(2), ball.model, ball.state, resized(ball.ct.grid, ball.ct.grid.size * 2));
    const Mat3d to_lattice = inverse(ball.model.grid.axes);
    const std::size_t middle = ball.path.skin.size() / 2;
    int looked_at = 0, wrong = 0;
    for (int k = 0; k < back.grid.size.z; k++)
      for (int j = 0; j < back.grid.size.y; j++)
        for (int i = 0; i < back.grid.size.x; i++) {
          const Vec3d d(back.samples[sample_index(back.grid, i, j, k)]);
          if (norm(d) == 0) continue;
          const Vec3d now = to_lattice * (point_at(back.grid, Vec3d(Int3{i, j, k})) - ball.model.grid.origin),
                      moved = -(to_lattice * d), rest = now - moved;
          const Vec3d from_middle = rest - ball.path.skin[middle];
          const double aside = ball.right_of_blade(rest);
          if (norm(from_middle) > 7e-3 || std::abs(aside) > 3e-3 || std::abs(aside) < kLip) continue;
          looked_at++;
          wrong += dot(moved, across_at(ball.path, middle)) * aside < -0.3e-3 * std::abs(aside);
        }
    std::printf("  a wound of %.1f mm: %d voxels beside it, %d go with the other side\n",
                wound.gape_max * 1e3, looked_at, wrong);
    EXPECT_GT(looked_at, 50);
    EXPECT_EQ(wrong, 0);
  }
}

}  // namespace
}  // namespace turgor::lattice
