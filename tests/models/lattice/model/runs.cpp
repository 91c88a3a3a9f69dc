// What is swept: where there are nodes that can move, and nothing else.
#include <gtest/gtest.h>

#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);
constexpr double kDt = 1.0 / 60;

/// A torso with its lungs, bones and all the air around it.
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
  const Vec3d middle = point_at(model.grid, Vec3d(model.lattice.size) * 0.5);
  const Vec3d front{middle.x, model.grid.origin.y, middle.z};
  const BladePath path = lay_blade(model, state, {.from = front, .to = front + Vec3d{0, 0, 0.1}}).value();
  EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 10);
  for (int n = 0; n < 5; n++) step(kTwo, model, state, {.gravity = {0, 9.81, 0}}, kDt);
  return state_hash(model, state);
}

TEST(lattice_runs, every_node_that_can_move_is_in_a_run_and_every_group_of_a_run_has_one) {
  const Model model = torso(Method::kVbd, TissueLaw::kSprings);
  std::vector<int> covered(model.inverse_mass.size(), 0);
  for (const auto& run : model.moving.all)
    for (int group = run.begin; group < run.begin + run.count; group += kGroup) {
      bool any = false;
      for (int s = group; s < group + kGroup; s++)
        covered[std::size_t(s)]++, any |= model.inverse_mass[std::size_t(s)] > 0;
      EXPECT_TRUE(any) << "slot " << group;
      EXPECT_EQ(group % model.lattice.half % kGroup, 0);
    }
  for (std::size_t s = 0; s < covered.size(); s++) {
    ASSERT_LE(covered[s], 1);
    if (model.inverse_mass[s] > 0) {
      ASSERT_EQ(covered[s], 1) << "slot " << s;
    }
  }
}

TEST(lattice_runs, of_a_torso_in_its_air_less_than_two_thirds_are_swept) {
  for (const Method method : {Method::kVbd, Method::kPbd}) {
    const Model model = torso(method, TissueLaw::kSprings);
    EXPECT_LT(slots_in(model.moving), 0.6 * node_count(model.lattice));
    EXPECT_LT(slots_in(model.joining), 0.66 * node_count(model.lattice));
    EXPECT_GE(int(slots_in(model.moving)), model.free_nodes);
  }
}

TEST(lattice_runs, sweeping_air_and_bone_as_well_changes_no_bit) {
  const auto all = [](int) { return true; };
  for (const auto& [method, law] : {std::pair{Method::kVbd, TissueLaw::kSprings},
                                    {Method::kVbd, TissueLaw::kSolid},
                                    {Method::kPbd, TissueLaw::kSprings}}) {
    Model model = torso(method, law);
    const std::uint64_t hash = hash_after_a_cut(model);
    model.moving = find_runs(model.lattice, all);
    model.joining = find_runs(model.lattice, all);
    EXPECT_EQ(hash_after_a_cut(model), hash) << "method " << int(method) << ", law " << int(law);
  }
}

}  // namespace
}  // namespace turgor::lattice
