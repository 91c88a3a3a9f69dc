// Permanent set of cells: a bar under a step load and after its release, against the closed form.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"

namespace turgor::lattice {
namespace {

const Exec kThreads(2);
constexpr double kYoung = 1e4;

/// A bar of 4 by 3 by 3 nodes, loaded along x by a stress [Pa]. A free bar would turn over under pressure, so
/// a pressed one is fixed at an end and has no Poisson's ratio.
struct Bar {
  double poisson;
  Model model;
  State state;

  explicit Bar(const PermanentSet& set, const Prony& prony = {}, bool is_fixed = false)
      : poisson(is_fixed ? 0 : 0.3) {
    Params params;
    params.skin.enabled = false;
    params.tissue.law = TissueLaw::kSolid;
    params.tissue.poisson = poisson;
    params.tissue.set = set, params.tissue.prony = prony;
    params.solver = {.sweeps = 12, .damping = 0};
    Block block{.size = {4, 3, 3}, .young = kYoung, .skin_on_top = false};
    block.is_fixed = [is_fixed](Int3 p) { return is_fixed && p.x == 0; };
    model = block_model(block, params);
    state = make_state(model);
  }
  std::vector<NodeLoad> loads(double stress) const {
    const Lattice& l = model.anatomy.lattice;
    const Vec3d h(l.spacing);
    std::vector<NodeLoad> list;
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (const int i : {0, l.size.x - 1}) {
          const double share = (j == 1 ? 1.0 : 0.5) * (k == 1 ? 1.0 : 0.5);
          list.push_back(
              {node_slot(l, {i, j, k}), {Real((i == 0 ? -1 : 1) * stress * share * h.y * h.z), 0, 0}});
        }
    std::sort(list.begin(), list.end(), [](const NodeLoad& a, const NodeLoad& b) { return a.slot < b.slot; });
    return list;
  }
  void run(double stress, double seconds) {
    constexpr double kStep = 1.0 / 120;
    const std::vector<NodeLoad> list = loads(stress);
    for (int n = 0; n < std::lround(seconds / kStep); n++)
      step(kThreads, model, state, {.loads = list}, kStep);
  }
  double strain() const {
    const Lattice& l = model.anatomy.lattice;
    return (double(state.motion.u[std::size_t(node_slot(l, {l.size.x - 1, 1, 1}))].x) -
            double(state.motion.u[std::size_t(node_slot(l, {0, 1, 1}))].x)) /
           (double(l.spacing.x) * (l.size.x - 1));
  }
};

/// Strain that has set after t seconds: E ε = share (σ − E ε₀)/(1 − share) (1 − exp(−(1 − share) t/τ)), where
/// the equivalent strain of a bar is ⅔ (1 + ν) of its elongation.
double set_strain(const PermanentSet& set, double poisson, double stress, double t) {
  const double elongation = set.strain / (2.0 / 3 * (1 + poisson));
  const double beyond = std::max(0.0, stress / kYoung - elongation);
  return set.share * beyond / (1 - set.share) * -std::expm1(-(1 - set.share) * t / set.time);
}

// A bar under a step load creeps as the closed form, in tension and under pressure; without the load, the set
// stays to the last digits.
TEST(PermanentSet, BarMatchesClosedForm) {
  const PermanentSet set{.strain = 0.002, .share = 0.4, .time = 0.5};
  for (const double stress : {60.0, -60.0, 35.0}) {
    Bar bar(set, {}, stress < 0);
    const double sign = stress < 0 ? -1 : 1;
    double time = 0;
    for (const double until : {0.25, 1.0, 4.0}) {
      bar.run(stress, until - time);
      time = until;
      const double expected =
          std::abs(stress) / kYoung + set_strain(set, bar.poisson, std::abs(stress), until);
      EXPECT_NEAR(sign * bar.strain(), expected, 0.02 * expected) << stress << " Pa, " << until << " s";
    }
    // release
    bar.run(0, 1);
    const double left = sign * bar.strain(), expected = set_strain(set, bar.poisson, std::abs(stress), 4);
    EXPECT_NEAR(left, expected, 0.02 * std::abs(stress) / kYoung) << stress;
    bar.run(0, 3);
    EXPECT_NEAR(sign * bar.strain(), left, 1e-3 * left) << "stays";
    // the set in three directions, without the change of volume
    EXPECT_NEAR(largest_set(kThreads, bar.model, bar.state), 2.0 / 3 * (1 + bar.poisson) * left, 0.03 * left);
  }
}

// A load below the strain leaves nothing, and a bar that relaxes sets as much as an elastic one in the end.
TEST(PermanentSet, BelowTheStrainNothingStays) {
  Bar bar({.strain = 0.006, .share = 0.5, .time = 0.2});
  bar.run(60, 2);
  bar.run(0, 2);
  EXPECT_LT(std::abs(bar.strain()), 1e-5);
  EXPECT_EQ(largest_set(kThreads, bar.model, bar.state), 0);

  const PermanentSet set{.strain = 0.002, .share = 0.4, .time = 0.2};
  Prony prony;
  prony.pairs[0] = {0.5, 0.1};
  Bar relaxing(set, prony);
  relaxing.run(60, 4);
  relaxing.run(0, 3);
  EXPECT_NEAR(relaxing.strain(), set_strain(set, relaxing.poisson, 60, 100), 0.05 * 60 / kYoung);
}

}  // namespace
}  // namespace turgor::lattice
