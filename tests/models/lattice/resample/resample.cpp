#include "turgor/models/lattice/resample/resample.hpp"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/deformed_body.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(1);

// The deformed CT of a body at rest equals its CT.
TEST(LatticeResample, BodyAtRestEqualsCt) {
  for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}, {7, 4, 6}}) {
    const CtVolume ct = ball_ct(41, 15);
    const Model model = body_of(ct, block);
    const ResampledCt result = resample_ct(kExec, model, make_state(model), ct, ct.grid);
    EXPECT_TRUE(result.ct.samples == ct.samples);
    EXPECT_EQ(result.report.inverted_tets, 0);
    EXPECT_EQ(result.report.overlaps, 0);
    EXPECT_NEAR(result.report.mass_error, 0, 1e-12);
  }
}

// A displacement by whole voxels shifts the CT.
TEST(LatticeResample, WholeVoxelShiftMovesCt) {
  const CtVolume ct = ball_ct(48, 14);
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  const Int3 by{3, -5, 2};
  move(model, state, [&](Vec3d) { return Vec3d(by) * kVoxel; });
  const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
  long wrong = 0;
  for_voxels(ct.grid, [&](Int3 p) { wrong += at_or_air(result.ct, p) != at_or_air(ct, p - by); });
  EXPECT_EQ(wrong, 0);
  EXPECT_NEAR(result.report.mass_error, 0, 1e-12);
}

// An output grid with swapped axes shows the same body.
TEST(LatticeResample, PermutedOutputGrid) {
  const CtVolume ct = ball_ct(40, 14);
  const Model model = body_of(ct, {4, 4, 4});
  Grid turned = ct.grid;  // i and j swapped: a left-handed frame
  turned.axes = {{ct.grid.axes.column[1], ct.grid.axes.column[0], ct.grid.axes.column[2]}};
  const ResampledCt result = resample_ct(kExec, model, make_state(model), ct, turned);
  long wrong = 0;
  for_voxels(ct.grid, [&](Int3 p) { wrong += result.ct.at(p.y, p.x, p.z) != ct.at(p.x, p.y, p.z); });
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(result.report.inverted_tets, 0);
}

// A resized grid has the same extent, and its voxels are means.
TEST(LatticeResample, ResizedGridKeepsExtent) {
  const CtVolume ct = ball_ct(40, 14);
  const Grid half = resized(ct.grid, {20, 10, 40});
  EXPECT_NEAR(norm(point_at(half, {-0.5, -0.5, -0.5}) - point_at(ct.grid, {-0.5, -0.5, -0.5})), 0, 1e-15);
  EXPECT_NEAR(norm(point_at(half, {19.5, 9.5, 39.5}) - point_at(ct.grid, {39.5, 39.5, 39.5})), 0, 1e-15);
  const Model model = body_of(ct, {4, 4, 4});
  const ResampledCt result = resample_ct(kExec, model, make_state(model), ct, resized(ct.grid, {20, 20, 20}));
  // A voxel of twice the size is the mean of its eight voxels, rounded.
  for_voxels(result.ct.grid, [&](Int3 p) {
    double sum = 0;
    for (int c = 0; c < 8; c++) sum += ct.at(2 * p.x + (c & 1), 2 * p.y + (c >> 1 & 1), 2 * p.z + (c >> 2));
    ASSERT_NEAR(result.ct.at(p.x, p.y, p.z), sum / 8, 0.51);
  });
  EXPECT_NEAR(result.report.mass_error, 0, 0.01);
}

// A uniform stretch conserves the mass if requested.
TEST(LatticeResample, StretchConservesMassOnRequest) {
  const CtVolume ct = ball_ct(64, 20);
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  move(model, state, [](Vec3d p) {
    return Vec3d{0.2 * (p.x - 0.032), 0.1 * (p.y - 0.032), -0.1 * (p.z - 0.032)};
  });
  const ResampledCt kept = resample_ct(kExec, model, state, ct, ct.grid, {.conserve_mass = true});
  EXPECT_NEAR(kept.report.mass_error, 0, 0.01);
  const ResampledCt plain = resample_ct(kExec, model, state, ct, ct.grid);
  EXPECT_NEAR(plain.report.mass_error, 1.2 * 1.1 * 0.9 - 1, 0.01) << "without, mass grows with the volume";

  const ScalarVolume jacobian = resample_jacobian(kExec, model, state, ct.grid);
  EXPECT_NEAR(jacobian.at(32, 32, 32), 1.2 * 1.1 * 0.9, 1e-3);
  EXPECT_EQ(jacobian.at(0, 0, 0), 1);
}

// The displacement field points back to the CT, and is zero outside of the body.
TEST(LatticeResample, DisplacementFieldPointsToCt) {
  CtVolume ct = ball_ct(40, 14);
  ct.grid.axes = {{Vec3d{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  move(model, state, [](Vec3d) { return Vec3d{0.002, 0.001, 0}; });
  const VectorVolume field = resample_displacement(kExec, model, state, ct.grid);
  const Vec3 expected(-(ct.grid.axes * Vec3d{0.002, 0.001, 0}));
  EXPECT_NEAR(norm(field.at(20, 20, 20) - expected), 0, 1e-7);
  EXPECT_EQ(field.at(1, 1, 1), Vec3{});
}

// Deformed positions of the nodes, computed without the code under test.
struct DeformedNodes {
  const Model& model;
  std::vector<std::optional<Vec3d>> voxel;  // by slot: tissue, or air beside tissue

  DeformedNodes(const Model& m, const State& state) : model(m), voxel(m.anatomy.tissue.size()) {
    const Int3 size = m.anatomy.lattice.size;
    for (int k = 0; k < size.z; k++)
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++) {
          Vec3d sum, beside_sum;
          int count = 0, beside_count = 0;
          const Int3 p{i, j, k};
          const auto is_tissue = [&](Int3 q) {
            return contains(m.anatomy.lattice, q) &&
                   is_body(m.anatomy.tissue[std::size_t(node_slot(m.anatomy.lattice, q))]);
          };
          const auto u = [&](Int3 q) {
            return Vec3d(state.motion.u[std::size_t(node_slot(m.anatomy.lattice, q))]);
          };
          if (is_tissue(p)) {
            sum = u(p), count = 1;
          } else {
            Vec3d sums[3];  // along axes, along other lattice edges, and along other diagonals
            int counts[3] = {};
            for (int n = 0; n < 27; n++) {
              const Int3 offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
              if (!is_tissue(p + offset)) continue;
              const bool is_edge = family_of(offset) >= 0 || family_of(-offset) >= 0,
                         is_axis = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z) == 1;
              if (is_edge) beside_sum += u(p + offset), beside_count++;
              if (!is_tissue(p + offset + offset)) continue;
              // Linear extrapolation from the last two nodes, but no shorter than at rest.
              const Vec3d rest = hadamard(Vec3d(-offset), m.anatomy.grid.spacing);
              const Vec3d now = rest + u(p + offset) - u(p + offset + offset);
              const std::size_t kind = is_axis ? 0 : is_edge ? 1 : 2;
              sums[kind] += u(p + offset) + now * std::max(1.0, norm(rest) / norm(now)) - rest,
                  counts[kind]++;
            }
            for (int kind = 0; kind < 3 && count == 0; kind++) {
              if (kind == 2 && beside_count == 0) break;
              sum = sums[kind], count = counts[kind];
            }
            if (count == 0) sum = beside_sum, count = beside_count;
          }
          if (count > 0)
            voxel[std::size_t(node_slot(m.anatomy.lattice, p))] =
                (hadamard(Vec3d(p), m.anatomy.grid.spacing) + sum / double(count)) / kVoxel -
                Vec3d{0.5, 0.5, 0.5};
        }
  }
};

// Every voxel comes from the one tetrahedron that contains it.
TEST(LatticeResample, VoxelsComeFromTheirTetrahedron) {
  const CtVolume ct = ball_ct(32, 11);
  const Model model = body_of(ct, {4, 4, 4});
  for (const double phase : {0.3, 1.7, 2.9}) {
    State state = make_state(model);
    move(model, state, [&](Vec3d p) { return wobble(p, 0.0025, 0.03, phase); });
    const DeformedNodes deformed(model, state);
    std::vector<int> holders(sample_count(ct.grid)), unsure(holders.size()), visits(holders.size());
    std::vector<Vec3d> origin(holders.size());
    const Int3 size = model.anatomy.lattice.size;
    Grid cells;
    cells.size = size - Int3{1, 1, 1};
    for_voxels(cells, [&](Int3 cell) {
      for (const auto& tet : kKuhnTets) {
        Vec3d x[4];
        bool tissue = false, known = true;
        for (int n = 0; n < 4; n++) {
          const auto slot = std::size_t(node_slot(model.anatomy.lattice, cell + tet[std::size_t(n)]));
          tissue |= is_body(model.anatomy.tissue[slot]);
          known &= deformed.voxel[slot].has_value();
          if (known) x[n] = *deformed.voxel[slot];
        }
        if (!tissue) continue;
        const Mat3d back = inverse({{x[1] - x[0], x[2] - x[0], x[3] - x[0]}});
        const Vec3d low = min(min(x[0], x[1]), min(x[2], x[3])), high = max(max(x[0], x[1]), max(x[2], x[3]));
        for (int k = int(std::floor(low.z)); k <= high.z + 1; k++)
          for (int j = int(std::floor(low.y)); j <= high.y + 1; j++)
            for (int i = int(std::floor(low.x)); i <= high.x + 1; i++) {
              if (!contains(ct.grid, {i, j, k})) continue;
              const Vec3d w = back * (Vec3d{double(i), double(j), double(k)} - x[0]);
              const double least = std::min({w.x, w.y, w.z, 1 - w.x - w.y - w.z});
              const std::size_t v = sample_index(ct.grid, i, j, k);
              unsure[v] |= std::abs(least) < 2e-3;  // so close to a face that fixed-point rounding may decide
              if (least <= 0) continue;
              holders[v]++;
              origin[v] = hadamard(Vec3d(cell + tet[0]) + Vec3d(tet[1] - tet[0]) * w.x +
                                       Vec3d(tet[2] - tet[0]) * w.y + Vec3d(tet[3] - tet[0]) * w.z,
                                   Vec3d{4, 4, 4}) -
                          Vec3d{0.5, 0.5, 0.5};
            }
      }
    });
    const DeformedBody body = deform_body(kExec, model, state, ct.grid);
    long compared = 0;
    for (int slab = 0; slab < slab_count(body); slab++)
      EXPECT_EQ(walk_slab(body, slab, {.first_node = {-0.5, -0.5, -0.5}, .cell_size = {4, 4, 4}},
                          [&](Int3, Int3 p, Vec3 at, float) {
                            const std::size_t v = sample_index(ct.grid, p.x, p.y, p.z);
                            visits[v]++;
                            if (unsure[v]) return;
                            compared++;
                            ASSERT_NEAR(norm(Vec3d(at) - origin[v]), 0, 5e-3);
                          }),
                0);
    EXPECT_GT(compared, 5000);
    long differing = 0, twice = 0;
    for (std::size_t v = 0; v < visits.size(); v++) {
      differing += !unsure[v] && visits[v] != holders[v];
      twice += visits[v] > 1;
    }
    EXPECT_EQ(differing, 0);
    EXPECT_EQ(twice, 0);
  }
}

// Every voxel inside a deformed body is visited exactly once, also on faces of tetrahedra.
TEST(LatticeResample, NoVoxelIsMissedOnFaces) {
  // Displacements by half and quarter voxels put many centers exactly on faces and edges.
  const CtVolume ct = make_ct({40, 40, 40}, [](Vec3d) { return true; });
  const Model model = body_of(ct, {4, 4, 4});
  for (const double by : {0.25, 0.5, 0.75}) {
    State state = make_state(model);
    move(model, state, [&](Vec3d p) {
      return Vec3d{by * kVoxel, -by * kVoxel, 0.5 * by * kVoxel} + Vec3d{0.125 * p.y, 0, 0};
    });
    const DeformedBody body = deform_body(kExec, model, state, ct.grid);
    std::vector<int> visits(sample_count(ct.grid));
    for (int slab = 0; slab < slab_count(body); slab++)
      walk_slab(body, slab, {.first_node = {-0.5, -0.5, -0.5}, .cell_size = {4, 4, 4}},
                [&](Int3, Int3 p, Vec3, float) { visits[sample_index(ct.grid, p.x, p.y, p.z)]++; });
    for_voxels(ct.grid, [&](Int3 p) {
      const double x = p.x + 0.5 - by - 0.125 * (p.y + 0.5 + by), y = p.y + 0.5 + by,
                   z = p.z + 0.5 - 0.5 * by;
      const bool inside = x > 1e-9 && x < 40 - 1e-9 && y > 0 && y < 40 && z > 0 && z < 40;
      ASSERT_LE(visits[sample_index(ct.grid, p.x, p.y, p.z)], 1);
      if (inside) {
        ASSERT_EQ(visits[sample_index(ct.grid, p.x, p.y, p.z)], 1) << p.x << " " << p.y << " " << p.z;
      }
    });
  }
}

// One, two and eight threads give the same bits.
TEST(LatticeResample, EqualBitsOnAnyThreads) {
  const CtVolume ct = ball_ct(48, 18);
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  move(model, state, [](Vec3d p) { return wobble(p, 0.012, 0.03, 0.4); });  // strong enough to invert cells
  const ResampledCt one = resample_ct(Exec(1), model, state, ct, ct.grid);
  EXPECT_GT(one.report.inverted_tets, 0);
  EXPECT_GT(one.report.overlaps, 0);
  for (const int threads : {2, 8}) {
    const ResampledCt many = resample_ct(Exec(threads), model, state, ct, ct.grid);
    EXPECT_TRUE(many.ct.samples == one.ct.samples) << threads;
    EXPECT_EQ(many.report.inverted_tets, one.report.inverted_tets);
    EXPECT_EQ(many.report.overlaps, one.report.overlaps);
    EXPECT_EQ(many.report.mass_error, one.report.mass_error);
  }
}

// Every inverted tetrahedron is counted once.
TEST(LatticeResample, InvertedTetrahedraAreCountedOnce) {
  const CtVolume ct = make_ct({32, 32, 32}, [](Vec3d) { return true; });
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  // One inner node is pushed through its neighbors along k, across several slabs of the output.
  state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, 4, 4, 4)), {0, 0, 0.009f});
  long expected = 0;
  for (int c = 0; c < 8; c++)
    for (const auto& tet : kKuhnTets) {
      Vec3 x[4];
      for (int n = 0; n < 4; n++)
        x[n] = position(model, state.motion,
                        Int3{3 + (c & 1), 3 + (c >> 1 & 1), 3 + (c >> 2)} + tet[std::size_t(n)]);
      expected += dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) <= 0;
    }
  EXPECT_GT(expected, 0);
  EXPECT_EQ(resample_ct(kExec, model, state, ct, ct.grid).report.inverted_tets, expected);
}

// A closed cut does not change the CT.
TEST(LatticeResample, ClosedCutIsInvisible) {
  const CtVolume ct = ball_ct(40, 15);
  const Model model = body_of(ct, {4, 4, 4});
  for (const double at : {0.0193, 0.020, 0.0217}) {
    State state = make_state(model);
    ASSERT_GT(cut_across_y(model, state, at, [](Vec3d p) { return p.z > 0.017; }), 50);
    const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
    EXPECT_TRUE(result.ct.samples == ct.samples);
    EXPECT_EQ(result.report.overlaps, 0);
    EXPECT_NEAR(result.report.mass_error, 0, 1e-12);
  }
}

// An open cut shows air between two intact lips.
TEST(LatticeResample, OpenCutShowsAirBetweenLips) {
  const CtVolume ct = ball_ct(48, 15);
  const Model model = body_of(ct, {4, 4, 4});
  for (const double at : {0.0233, 0.024, 0.0257}) {
    State state = make_state(model);
    cut_across_y(model, state, at, [](Vec3d) { return true; });
    const Int3 by{0, 6, 1};
    move(model, state, [&](Vec3d p) { return p.y >= at ? Vec3d(by) * kVoxel : Vec3d{}; });
    const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
    const auto is_moved = [&](Int3 p) { return (p.y + 0.5) * kVoxel >= at; };  // by its position in the CT
    long wrong = 0, wrong_inside = 0, tissue = 0, gap = 0;
    for_voxels(ct.grid, [&](Int3 p) {
      std::int16_t expected = kAirHu;
      if (!is_moved(p) && at_or_air(ct, p) != kAirHu) expected = at_or_air(ct, p);
      if (is_moved(p - by) && at_or_air(ct, p - by) != kAirHu) expected = at_or_air(ct, p - by);
      const bool deep = norm(Vec3d(is_moved(p - by) ? p - by : p) - Vec3d{23.5, 23.5, 23.5}) < 10;
      wrong += at_or_air(result.ct, p) != expected;
      wrong_inside += deep && at_or_air(result.ct, p) != expected;
      tissue += expected != kAirHu;
      gap += expected == kAirHu && at_or_air(ct, p) != kAirHu;
    });
    EXPECT_GT(gap, 2000);
    EXPECT_EQ(wrong_inside, 0) << "cut at " << at;
    // A tetrahedron with one tissue node ignores cuts: the rim of a lip may move with the other lip.
    EXPECT_LT(double(wrong), 0.04 * double(tissue)) << "cut at " << at;
    EXPECT_NEAR(result.report.mass_error, 0, 1e-12);
  }
}

// A wound that ends inside the body loses no tissue.
TEST(LatticeResample, InnerWoundLosesNoTissue) {
  const CtVolume ct =
      make_ct({64, 64, 40}, [](Vec3d p) { return p.x > 5 && p.x < 58 && p.y > 5 && p.y < 58 && p.z < 30; });
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  const double at = 0.0313, bottom = 0.019;
  cut_across_y(model, state, at, [&](Vec3d p) { return p.z > bottom && std::abs(p.x - 0.032) < 0.016; });
  // Opens like a lens, 8 mm wide at the skin and closed at the bottom and the ends.
  const auto opening = [&](Vec3d p) {
    const double along = (p.x - 0.032) / 0.02, across = (p.y - at) / 0.024;
    const double deep = std::clamp((p.z - bottom + 0.004) / 0.014, 0.0, 1.0);
    return 0.004 * deep * std::max(0.0, 1 - along * along) * std::max(0.0, 1 - std::abs(across));
  };
  move(model, state, [&](Vec3d p) { return Vec3d{0, p.y >= at ? opening(p) : -opening(p), 0}; });
  const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid, {.conserve_mass = true});
  EXPECT_NEAR(result.report.mass_error, 0, 0.01);
  EXPECT_EQ(result.report.inverted_tets, 0);
  EXPECT_LT(result.report.overlaps, 40) << "the ghosts of the lips hardly overlap";
  EXPECT_EQ(result.ct.at(31, 31, 28), kAirHu) << "in the wound";
  EXPECT_NE(result.ct.at(31, 37, 27), kAirHu) << "beside the wound";
  EXPECT_NE(result.ct.at(31, 31, 14), kAirHu) << "below the wound";
}

// Removed nodes become air.
TEST(LatticeResample, RemovedNodesBecomeAir) {
  const CtVolume ct = make_ct({40, 40, 40}, [](Vec3d p) { return p.z < 30; });
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  remove_block(model, state);
  const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
  EXPECT_EQ(result.ct.at(20, 20, 22), kAirHu);
  EXPECT_EQ(result.ct.at(20, 20, 15), ct.at(20, 20, 15));
  EXPECT_EQ(result.ct.at(8, 20, 22), ct.at(8, 20, 22));
  long air = 0;
  for_voxels(ct.grid,
             [&](Int3 p) { air += result.ct.at(p.x, p.y, p.z) == kAirHu && ct.at(p.x, p.y, p.z) != kAirHu; });
  EXPECT_NEAR(double(air), 12 * 12 * 12, 0.35 * 12 * 12 * 12);
  EXPECT_NEAR(result.report.mass_error, 0, 1e-12) << "removed tissue does not count as an error";
}

}  // namespace
}  // namespace turgor::lattice
