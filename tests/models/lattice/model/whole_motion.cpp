// A body in rigid motion has that motion as a whole.
#include "turgor/models/lattice/model/whole_motion.hpp"

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

TEST(WholeMotion, AddedVelocity_IsFound) {
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  const Model model = block_model({.size = {4, 5, 7}, .skin_on_top = false}, params);
  State state = make_state(model);
  const Vec3d center = whole_motion(model, state).center, velocity{0.1, -0.2, 0.3}, spin{1, 2, -3};
  add_velocity(model, center, velocity, spin, state);
  const WholeMotion whole = whole_motion(model, state);
  EXPECT_LT(norm(whole.velocity - velocity), 1e-6 * norm(velocity));
  EXPECT_LT(norm(whole.spin - spin), 1e-5 * norm(spin));
  EXPECT_LT(norm(whole.center - Vec3d{0.006, 0.008, 0.012}), 1e-6);
}

// A torque about the center turns the body by its inertia: a pair of opposite impulses at two nodes.
TEST(WholeMotion, PairOfImpulses_TurnsByInertia) {
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  const Model model = block_model({.size = {4, 5, 7}, .skin_on_top = false}, params);
  State state = make_state(model);
  const int ends[] = {node_slot(model.anatomy.lattice, 0, 0, 0), node_slot(model.anatomy.lattice, 3, 4, 6)};
  const Vec3d impulse{2e-3, -1e-3, 1e-3};
  Vec3d torque;
  const WholeMotion before = whole_motion(model, state);
  for (const double sign : {-1.0, 1.0}) {
    const int slot = ends[sign > 0];
    state.motion.v.set(std::size_t(slot),
                       Vec3(impulse * sign * double(model.anatomy.inverse_mass[std::size_t(slot)])));
    torque += cross(node_position(model, state, slot) - before.center, impulse * sign);
  }
  const WholeMotion whole = whole_motion(model, state);
  EXPECT_LT(norm(whole.velocity) * whole.mass, 1e-5 * norm(impulse));
  EXPECT_LT(norm(whole.spin - before.inverse_inertia * torque), 1e-5 * norm(whole.spin));
}

}  // namespace
}  // namespace turgor::lattice
