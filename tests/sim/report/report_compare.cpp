#include "turgor/sim/report/report_compare.hpp"

#include <gtest/gtest.h>

#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

// Elements and chains have a force in each tick, the other models in each frame.
TEST(ForceInterval, IsATickOfElementsAndChainsOnly) {
  World world;
  world.dt = 0.02;
  for (const BodyKind kind : {BodyKind::kSfem, BodyKind::kRhombus})
    EXPECT_EQ(force_interval(world, {kind, 0}), 0.001);
  for (const BodyKind kind : {BodyKind::kLattice, BodyKind::kCloth, BodyKind::kRigid})
    EXPECT_EQ(force_interval(world, {kind, 0}), 0.02);
}

}  // namespace
}  // namespace turgor
