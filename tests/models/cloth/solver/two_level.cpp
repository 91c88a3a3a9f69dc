#include "turgor/models/cloth/solver/two_level.hpp"

#include <numbers>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {
namespace {

/// A square of a meter, held at its first column, that falls for a quarter of a second.
struct Falling {
  int most_iterations = 0;  // largest number of iterations of a step
  double residual = 0;
};
Falling fall(int cells, Method method) {
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = method, .sweeps = 3000}};
  params.collision.self = false;
  const TriMesh mesh = make_sheet({.columns = cells, .rows = cells});
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  for (const int v : vertices_between(mesh, -1, 1e-6)) EXPECT_TRUE(hold(model, state, v));
  Falling falling;
  for (int n = 0; n < 15; n++) {
    const StepReport report = step(Exec(2), model, state, in_vacuum(), kFrame);
    falling.most_iterations = std::max(falling.most_iterations, report.iterations);
    falling.residual = std::max(falling.residual, report.residual);
  }
  return falling;
}

// Iterations of the two-level preconditioner hardly grow with the mesh.
TEST(ClothTwoLevel, IterationsHardlyGrowWithMesh) {
  const Falling coarse = fall(20, Method::kTwoLevel), fine = fall(80, Method::kTwoLevel);
  const Falling alone = fall(80, Method::kConjugateGradients);
  EXPECT_LT(coarse.residual, 0.0101);
  EXPECT_LT(fine.residual, 0.0101);
  EXPECT_LT(fine.most_iterations, 2.2 * coarse.most_iterations) << coarse.most_iterations;
  EXPECT_LT(fine.most_iterations, 0.2 * alone.most_iterations) << alone.most_iterations;
}

// The preconditioned solver has the solution of plain conjugate gradients.
TEST(ClothTwoLevel, MatchesPlainConjugateGradients) {
  Params params{.fabric = {.law = Law::kSheet},
                .solver = {.method = Method::kTwoLevel, .sweeps = 400, .tolerance = 0}};
  params.collision.self = false;
  const Model model = must_build(rectangle(Pattern::kRandom, 0, 0.2, 0.1, 0.01), params);
  State state = make_state(model);
  EXPECT_TRUE(hold(model, state, 3));
  shake(model, state.x, 0.003);
  shake(model, state.v, 0.1, 2);
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.air.velocity = {3, 0, 1};
  assemble(Exec(1), model, state, inputs, kFrame);
  Vectors found[2];
  for (const bool blocks : {false, true}) {
    start_change(Exec(1), model, state, kFrame);
    solve_by_conjugate_gradients(Exec(1), model, state,
                                 {.iterations = 400, .residual = 1e-6, .two_level = blocks});
    EXPECT_LT(state.system.residual, 1e-5);
    found[blocks] = state.system.change;
  }
  double size = 0, error = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    size = std::max(size, double(norm(found[0][v])));
    error = std::max(error, double(norm(found[1][v] - found[0][v])));
  }
  EXPECT_LT(error / size, 1e-4);
}

bool are_a_pair(const Blocks& blocks, int a, int b) {
  const auto larger = std::size_t(std::max(a, b));
  const auto begin = blocks.pair.begin() + blocks.pair_begin[larger],
             end = blocks.pair.begin() + blocks.pair_begin[larger + 1];
  return std::binary_search(begin, end, std::min(a, b));
}

// Bending springs join blocks that no edge joins.
TEST(ClothTwoLevel, BendingSpringsJoinBlocks) {
  Params params{.fabric = {.law = Law::kSprings, .bend = 1}, .solver = {.method = Method::kTwoLevel}};
  params.collision.self = false;
  const Model folds = must_build(make_sheet({.columns = 60, .rows = 60}), params);
  params.fabric.bend = 0;
  const Model edges = must_build(make_sheet({.columns = 60, .rows = 60}), params);
  EXPECT_GT(folds.blocks.pair.size(), edges.blocks.pair.size());
  for (const Model* model : {&folds, &edges}) {
    const Rows& rows = model->rows;
    for (int slot = 0; slot < rows.slot_begin.back(); slot++) {
      const auto batch = std::upper_bound(rows.slot_begin.begin(), rows.slot_begin.end(), slot) - 1;
      for (int l = 0; l < kLanes; l++) {
        if (!(rows.stiffness[std::size_t(slot * kLanes + l)] > 0)) continue;
        const int v = int(batch - rows.slot_begin.begin()) * kLanes + l;
        EXPECT_TRUE(are_a_pair(model->blocks, model->blocks.of[std::size_t(v)],
                               model->blocks.of[std::size_t(neighbor(rows, slot, l))]));
      }
    }
  }
}

/// Sag and end force of a strip of a meter whose ends are 0.8 m apart, relative to those of a catenary.
struct Hanging {
  double sag = 0, pull = 0;
};
Hanging hang(double cell) {
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel, .sweeps = 200}};
  params.damping.motion = 3;
  params.collision.self = false;
  const int cells = int(std::lround(1 / cell));
  const TriMesh mesh = make_sheet({.up = {0, cell, 0}, .columns = cells, .rows = 1});
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  const std::vector<int> left = vertices_between(mesh, -1, 1e-6), right = vertices_between(mesh, 1 - 1e-6, 2);
  for (const int v : left) EXPECT_TRUE(hold(model, state, v));
  for (const int v : right) EXPECT_TRUE(hold(model, state, v));
  for (int n = 1; n <= 600; n++) {
    for (const int v : right) {
      Vec3 goal = mesh.vertices[std::size_t(v)];
      goal.x -= Real(0.2 * std::min(1.0, n / 120.0));
      EXPECT_TRUE(move_hold(model, state, v, goal));
    }
    step(Exec(1), model, state, in_vacuum(), kFrame);
  }
  double scale = 0.8;  // a: 1 = 2 a sinh(0.8/2a)
  for (int n = 0; n < 200; n++) scale *= 1 + 0.3 * (2 * scale * std::sinh(0.8 / (2 * scale)) - 1);
  double low = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) low = std::min(low, double(state.x.z[v]));
  Vec3d pull;
  for (const int v : left) pull += hold_force(model, state, v, {0, 0, -9.81}, {}, kFrame);
  const double weight = model.total_mass * 9.81;
  return {-low / (scale * (std::cosh(0.4 / scale) - 1)),
          norm(pull) / (weight * scale * std::cosh(0.4 / scale))};
}

// A strip hangs as a catenary for any cell size.
TEST(ClothTwoLevel, StripHangsAsCatenary) {
  for (const double cell : {0.02, 0.01, 0.005}) {
    const Hanging found = hang(cell);
    EXPECT_NEAR(found.sag, 1, 0.01) << cell;
    EXPECT_NEAR(found.pull, 1, 0.01) << cell;
  }
}

// The holds of a hanging sheet carry its weight within 0.1 %.
TEST(ClothTwoLevel, HoldsCarryWeight) {
  for (const Pattern pattern : {Pattern::kDiagonal, Pattern::kRandom})
    for (const double cell : {0.02, 0.01}) {
      Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel, .sweeps = 200}};
      params.damping.motion = 2;
      params.collision.self = false;
      const TriMesh mesh = rectangle(pattern, 0, 0.2, 0.2, cell);
      const Model model = must_build(mesh, params);
      State state = make_state(model);
      const std::vector<int> held = vertices_between(mesh, -1, 1e-6);
      for (const int v : held) EXPECT_TRUE(hold(model, state, v));
      for (int n = 0; n < 300; n++) step(Exec(1), model, state, in_vacuum(), kFrame);
      Vec3d force;
      for (const int v : held) force += hold_force(model, state, v, {0, 0, -9.81}, {}, kFrame);
      const double weight = model.total_mass * 9.81;
      EXPECT_NEAR(force.z / weight, 1, 1e-3) << name(pattern) << ", " << cell << " m";
      EXPECT_LT(std::hypot(force.x, force.y), 1e-3 * weight) << name(pattern) << ", " << cell << " m";
    }
}

}  // namespace
}  // namespace turgor::cloth
