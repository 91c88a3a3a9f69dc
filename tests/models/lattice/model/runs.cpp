// Sweeps visit the nodes that can move and nothing else.
#include <gtest/gtest.h>

#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);
constexpr double kDt = 1.0 / 60;

/// A torso with its lungs and bones in air.
Model torso(Method method, TissueLaw law) {
  PhantomParams phantom = default_phantom(PhantomKind::kTorso);
  phantom.size = {128, 128, 75};
  phantom.spacing *= 4;
  Params params;
  params.solver.method = method;
  params.solver.pbd_volume = true;
  params.tissue.law = law;
  params.skin.law = method == Method::kPbd ? SkinLaw::kArea : SkinLaw::kFiber;
  return build(kTwo, make_phantom(kTwo, phantom), {}, params).value();
}

std::uint64_t hash_after_a_cut(const Model& model) {
  State state = make_state(model);
  const Vec3d middle = point_at(model.anatomy.grid, Vec3d(model.anatomy.lattice.size) * 0.5);
  const Vec3d front{middle.x, model.anatomy.grid.origin.y, middle.z};
  const BladePath path = lay_blade(model, state, {.from = front, .to = front + Vec3d{0, 0, 0.1}}).value();
  EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 10);
  for (int n = 0; n < 5; n++) step(kTwo, model, state, {.gravity = {0, 9.81, 0}}, kDt);
  return state_hash(model, state);
}

// Every free node is in exactly one run, and every group of a run has a free node.
TEST(LatticeRuns, CoverFreeNodesExactly) {
  const Model model = torso(Method::kVbd, TissueLaw::kSprings);
  std::vector<int> covered(model.anatomy.inverse_mass.size(), 0);
  for (const auto& run : model.anatomy.free_runs.all)
    for (int group = run.begin; group < run.begin + run.count; group += kGroup) {
      bool any = false;
      for (int s = group; s < group + kGroup; s++)
        covered[std::size_t(s)]++, any |= model.anatomy.inverse_mass[std::size_t(s)] > 0;
      EXPECT_TRUE(any) << "slot " << group;
      EXPECT_EQ(group % model.anatomy.lattice.half % kGroup, 0);
    }
  for (std::size_t s = 0; s < covered.size(); s++) {
    ASSERT_LE(covered[s], 1);
    if (model.anatomy.inverse_mass[s] > 0) {
      ASSERT_EQ(covered[s], 1) << "slot " << s;
    }
  }
}

// Less than two thirds of a torso's lattice are swept.
TEST(LatticeRuns, SweepLessThanTwoThirdsOfTorso) {
  for (const Method method : {Method::kVbd, Method::kPbd}) {
    const Model model = torso(method, TissueLaw::kSprings);
    EXPECT_LT(slots_in(model.anatomy.free_runs), 0.6 * node_count(model.anatomy.lattice));
    EXPECT_LT(slots_in(model.pbd.constraint_runs), 0.66 * node_count(model.anatomy.lattice));
    EXPECT_GE(int(slots_in(model.anatomy.free_runs)), model.anatomy.free_nodes);
  }
}

// Sweeping air and bone too changes no bit.
TEST(LatticeRuns, SweepingAllNodesEqualBits) {
  const auto all = [](int) { return true; };
  for (const auto& [method, law] : {std::pair{Method::kVbd, TissueLaw::kSprings},
                                    {Method::kVbd, TissueLaw::kSolid},
                                    {Method::kPbd, TissueLaw::kSprings}}) {
    Model model = torso(method, law);
    const std::uint64_t hash = hash_after_a_cut(model);
    model.anatomy.free_runs = find_runs(model.anatomy.lattice, all);
    model.pbd.constraint_runs = find_runs(model.anatomy.lattice, all);
    EXPECT_EQ(hash_after_a_cut(model), hash) << "method " << int(method) << ", law " << int(law);
  }
}

}  // namespace
}  // namespace turgor::lattice
