#include "turgor/sim/tools/touched_body.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Jaws of a tool on a path close in their time, at any rate of the ticks.
TEST(TouchingTool, JawsCloseInTheirTime) {
  for (const double dt : {5e-4, 1e-3, 4e-3}) {
    TouchingTool tool;
    tool.forceps.emplace(), tool.closing_time = 0.2;
    tool.path.rows = {{.time = 0, .position = {}, .hold = true}};
    for (int tick = 1; tick * dt < 0.1 + dt / 2; tick++) next_command(tool, tick * dt, dt);
    EXPECT_NEAR(tool.grip, 0.5, 1e-9) << dt << " s";
  }
}

}  // namespace
}  // namespace turgor
