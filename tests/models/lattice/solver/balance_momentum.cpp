// The momentum of a free body changes by the impulses of its loads and contacts, whatever the sweeps leave.
#include "turgor/models/lattice/solver/balance_momentum.hpp"

#include <cstdio>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/whole_motion.hpp"

namespace turgor::lattice {
namespace {

constexpr double kFrame = 1.0 / 60;

/// A free or a held block of solid cells, and a step with one sweep.
Model balanced_block(bool is_held) {
  Block block{.size = {5, 5, 6}, .skin_on_top = false};
  block.is_fixed = [is_held](Int3 p) { return is_held && p.z == 0; };
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  params.solver.sweeps = 1, params.solver.damping = 0, params.solver.coarse = false;
  return block_model(block, params);
}

/// Corner node on top, and one at the bottom.
int top_corner(const Model& model) { return node_slot(model.anatomy.lattice, 4, 4, 5); }
int bottom_node(const Model& model) { return node_slot(model.anatomy.lattice, 2, 2, 0); }

/// Hash after two steps with a load at the top and, at the bottom, a contact.
struct Stepped {
  State state;
  Vec3d impulse;  // of load and contact [N s]
};
Stepped stepped(const Model& model, bool balances, bool has_contact, bool is_held = false) {
  Stepped run{make_state(model), {}};
  const NodeLoad load{top_corner(model), {Real(0.01), Real(0.02), Real(-0.3)}};
  NodeContact contact{.slot = bottom_node(model),
                      .normal = {0, 0, 1},
                      .target = {0, 0, Real(1e-4)},
                      .friction = Real(0.3),
                      .is_held = is_held,
                      .force = {}};
  for (int n = 0; n < 2; n++) {
    Inputs inputs{.loads = {&load, 1}, .balances_momentum = balances};
    if (has_contact) inputs.contacts = {&contact, 1};
    EXPECT_TRUE(step(Exec(1), model, run.state, inputs, kFrame).finite);
    run.impulse += (Vec3d(load.force) + (has_contact ? Vec3d(contact.force) : Vec3d{})) * kFrame;
  }
  return run;
}
Vec3d momentum_of(const Model& model, const State& state) {
  const WholeMotion whole = whole_motion(model, state);
  return whole.velocity * whole.mass;
}

TEST(BalanceMomentum, FreeBody_TakesAllImpulses) {
  const Model model = balanced_block(false);
  for (const bool has_contact : {false, true}) {
    const Stepped balanced = stepped(model, true, has_contact), plain = stepped(model, false, has_contact);
    EXPECT_LT(norm(momentum_of(model, balanced.state) - balanced.impulse), 1e-5 * norm(balanced.impulse));
    EXPECT_GT(norm(momentum_of(model, plain.state) - plain.impulse), 0.01 * norm(plain.impulse))
        << "one sweep converges: this tests nothing";
  }
}

/// Angular momentum about the center [N m s].
Vec3d angular_momentum_of(const Model& model, const State& state) {
  const WholeMotion whole = whole_motion(model, state);
  return inverse(whole.inverse_inertia) * whole.spin;
}

// The angular momentum of a body at rest changes in a step by the torques of its load and contact.
TEST(BalanceMomentum, FreeBody_TakesAllTorques) {
  const Model model = balanced_block(false);
  const NodeLoad load{top_corner(model), {Real(1e-5), Real(2e-5), Real(-3e-4)}};
  for (const bool balances : {true, false}) {
    State state = make_state(model);
    NodeContact contact{
        .slot = bottom_node(model) + 1, .normal = {0, 0, 1}, .target = {0, 0, Real(1e-6)}, .force = {}};
    EXPECT_TRUE(step(Exec(1), model, state,
                     {.loads = {&load, 1}, .contacts = {&contact, 1}, .balances_momentum = balances}, kFrame)
                    .finite);
    const Vec3d center = whole_motion(model, state).center;
    Vec3d torque;
    for (const auto& [slot, force] : {std::pair{load.slot, load.force}, {contact.slot, contact.force}})
      torque += cross(node_position(model, state, slot) - center, Vec3d(force));
    const Vec3d impulse = torque * kFrame;
    const double error = norm(angular_momentum_of(model, state) - impulse) / norm(impulse);
    std::printf("balanced %d: off by %.2g\n", balances, error);
    if (balances)
      EXPECT_LT(error, 5e-3);
    else
      EXPECT_GT(error, 0.01) << "one sweep converges: this tests nothing";
  }
}

// A body with fixed nodes, and one with a held node, step with the same bits.
TEST(BalanceMomentum, HeldBody_SameBits) {
  const Model fixed = balanced_block(true), free = balanced_block(false);
  EXPECT_EQ(state_hash(fixed, stepped(fixed, true, false).state),
            state_hash(fixed, stepped(fixed, false, false).state));
  EXPECT_EQ(state_hash(free, stepped(free, true, true, true).state),
            state_hash(free, stepped(free, false, true, true).state));
}

}  // namespace
}  // namespace turgor::lattice
