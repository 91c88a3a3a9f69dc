#include "turgor/models/lattice/surface/surface_cache.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"

namespace turgor::lattice {
namespace {

// A surface that is rebuilt with a cache equals one built without it.
TEST(SurfaceCache, MatchesFullBuild) {
  const CtVolume ct = slab_ct();
  const Model model = body_of(ct, {4, 4, 4});
  State state = make_state(model);
  detail::SurfaceCache cache;
  const auto expect_same = [&](const char* when) {
    const BodySurface again = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(2), &cache),
                      uncached = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(2));
    EXPECT_EQ(again.triangles, uncached.triangles) << when;
    EXPECT_EQ(again.rest, uncached.rest) << when;
    EXPECT_EQ(again.slot, uncached.slot) << when;
    EXPECT_EQ(again.twin, uncached.twin) << when;
    EXPECT_EQ(again.skin_triangles, uncached.skin_triangles) << when;
    return again.triangles.size();
  };
  const std::size_t whole = expect_same("whole");
  cut_across_y(model, state, 0.0323, [](Vec3d p) { return p.z > 0.018 && std::abs(p.x - 0.032) < 0.013; });
  const std::size_t scratched = expect_same("cut in its upper layers");
  EXPECT_GT(scratched, whole);
  cut_across_y(model, state, 0.0323, [](Vec3d p) { return p.z > 0.008 && std::abs(p.x - 0.032) < 0.02; });
  EXPECT_GT(expect_same("cut deeper"), scratched);
  for (int i = 4; i < 8; i++) state.cuts.removed[std::size_t(node_slot(model.anatomy.lattice, i, 4, 1))] = 1;
  expect_same("with nodes removed near its bottom");
  std::fill(state.cuts.removed.begin(), state.cuts.removed.end(), std::uint8_t(0));
  expect_same("with these nodes restored");
}

/// Solid tissue whose cells at the surface are filled in part.
Params partial_cells() {
  Params params;
  params.block = {3, 3, 4};
  params.tissue.law = TissueLaw::kSolid, params.tissue.partial_cells = true;
  return params;
}

void expect_same_plan(const detail::SurfacePlan& found, const detail::SurfacePlan& expected) {
  ASSERT_EQ(found.corners, expected.corners);
  ASSERT_EQ(found.term_begin, expected.term_begin);
  ASSERT_EQ(found.triangles, expected.triangles);
  ASSERT_EQ(found.rest_around, expected.rest_around);
  for (std::size_t n = 0; n < expected.terms.size(); n++) {
    ASSERT_EQ(found.terms[n].near, expected.terms[n].near);
    ASSERT_EQ(found.terms[n].far, expected.terms[n].far);
    ASSERT_EQ(found.terms[n].offset, expected.terms[n].offset);
  }
  for (std::size_t v = 0; v < expected.of_vertex.size(); v++) {
    ASSERT_EQ(found.of_vertex[v].index, expected.of_vertex[v].index);
    ASSERT_EQ(found.of_vertex[v].weight, expected.of_vertex[v].weight);
  }
}

/// Cuts a ball by two blades and removes a block. After each step, a cached surface must have the bits of one
/// built at once.
void expect_cache_to_follow_blades(const CtVolume& ct, const Params& params) {
  const Model model = build(Exec(1), ct, {}, params).value();
  State state = make_state(model);
  std::array<detail::SurfaceCache, 3> caches;
  const auto expect_same = [&] {
    const BodySurface direct = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(1));
    for (std::size_t n = 0; n < 3; n++) {
      const Exec exec(std::array{1, 2, 8}[n]);
      const BodySurface cached = build_surface(model, state.cuts, &ct, Extent::kAll, exec, &caches[n]);
      ASSERT_EQ(cached.triangles, direct.triangles);
      ASSERT_EQ(cached.rest, direct.rest);
      ASSERT_EQ(cached.slot, direct.slot);
      ASSERT_EQ(cached.twin, direct.twin);
      ASSERT_EQ(cached.skin_triangles, direct.skin_triangles);
      ASSERT_EQ(cached.lips.size(), direct.lips.size());
      for (std::size_t v = 0; v < direct.rest.size(); v++) {
        ASSERT_EQ(cached.embedding[v].cell, direct.embedding[v].cell);
        ASSERT_EQ(cached.embedding[v].fragment, direct.embedding[v].fragment);
      }
      expect_same_plan(*cached.plan, *direct.plan);
    }
  };
  expect_same();
  const auto on_skin = [&ct](double x, double y) {
    return ct.grid.origin + (Vec3d{23.5, 23.5, 23.5} + Vec3d{x, y, std::sqrt(324 - x * x - y * y)}) * kVoxel;
  };
  const auto cut = [&](Vec3d from, Vec3d to, double tilt, int index) {
    const BladePath path =
        lay_blade(model, state, {.from = from, .to = to, .depth = 0.011, .tilt = tilt}).value();
    double begin = 0;
    for (const double end : {0.2, 0.21, 0.6, 1.0}) {
      cut_edges(model, state, path, begin, end, index);
      expect_same();
      begin = end;
    }
  };
  cut(on_skin(-11, 1), on_skin(10, -2), 0, 0);
  cut(on_skin(1, 0), on_skin(3, 11), 35, 1);
  remove_block(model, state);
  expect_same();
}

// While two blades move, a cached surface has the bits of one built at once, on any number of threads.
TEST(SurfaceCache, FollowsBlades) {
  Params params;
  params.block = {3, 3, 4};
  expect_cache_to_follow_blades(soft_ball(48, 18), params);
}

// Also where a blade loosens rim nodes of partial cells.
TEST(SurfaceCache, FollowsBladesInPartialCells) {
  expect_cache_to_follow_blades(soft_ball(48, 18), partial_cells());
}

// Rim nodes that a cut has loosened leave the cached surface without blades as it was.
TEST(SurfaceCache, LooseRimKeepsUncutSurface) {
  const CtVolume ct = soft_ball(48, 18);
  const Model model = build(Exec(1), ct, {}, partial_cells()).value();
  State state = make_state(model);
  detail::SurfaceCache cache;
  build_surface(model, state.cuts, &ct, Extent::kAll, Exec(1), &cache);
  const std::uint64_t before = cache.removed;
  int loose = 0;
  for (int slot = 0; slot < slot_count(model.anatomy.lattice); slot += 3)
    if (is_rim(model, slot)) state.cuts.removed[std::size_t(slot)] = kRemoved, loose++;
  ASSERT_GT(loose, 20);
  const BodySurface cached = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(1), &cache),
                    direct = build_surface(model, state.cuts, &ct, Extent::kAll, Exec(1));
  EXPECT_EQ(cache.removed, before);
  EXPECT_EQ(cached.triangles, direct.triangles);
  EXPECT_EQ(cached.rest, direct.rest);
  expect_same_plan(*cached.plan, *direct.plan);
}

}  // namespace
}  // namespace turgor::lattice
