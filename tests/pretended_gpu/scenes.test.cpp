// Whole scenes on a pretended GPU beside the same here.
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

/// A cut, and a hook that pulls one lip up.
struct Retracted {
  World world;
  Measures measures;
  std::vector<std::size_t> back;  // bytes that came back for each frame
};
Retracted retract(const std::string& device) {
  const Exec exec(2);
  const Scene scene = read_scene(TURGOR_SOURCE_DIR "/scenes/retract.toml",
                                 {"world.device=" + device, "body.torso.block=4",
                                  "body.torso.solver.schedule=colours", "world.duration=1.1"})
                          .value();
  Retracted run{.world = load_world(exec, scene).value(), .measures = {}, .back = {}};
  run.measures = make_measures(run.world);
  for (int n = 0; n < frame_count(scene); n++) {
    const std::size_t before = pretended_counts().back;
    const FrameReport frame = step(exec, run.world).value();
    EXPECT_TRUE(frame.finite);
    measure_frame(exec, run.world, frame, false, run.measures);
    run.back.push_back(pretended_counts().back - before);
  }
  return run;
}

TEST(PretendedGpuScenes, a_hook_pulls_a_lip_there_as_it_does_here_and_few_nodes_come_back) {
  const Retracted here = retract("cpu"), there = retract("gpu");
  const CutMeasures &wound_here = here.measures.cuts.at(0), &wound_there = there.measures.cuts.at(0);
  EXPECT_GT(wound_here.wound.gape_max, 2e-3) << "m";
  EXPECT_NEAR(wound_there.wound.gape_max, wound_here.wound.gape_max, 1e-3 * wound_here.wound.gape_max);
  EXPECT_NEAR(wound_there.wound.edge_displacement, wound_here.wound.edge_displacement,
              1e-3 * wound_here.wound.edge_displacement);
  const TouchLog &felt_here = here.world.tools.at(0).samples, &felt_there = there.world.tools.at(0).samples;
  ASSERT_EQ(felt_here.size(), felt_there.size());
  double largest = 0, apart = 0;
  for (std::size_t n = 0; n < felt_here.size(); n++) {
    largest = std::max(largest, norm(felt_here[n].force));
    apart = std::max(apart, norm(felt_here[n].force - felt_there[n].force));
  }
  EXPECT_GT(largest, 0.2) << "N";
  EXPECT_LT(apart, 0.01 * largest) << "N";

  const std::size_t state = 9 * sizeof(Real) * here.world.lattice_bodies.at(0).model.inverse_mass.size();
  const auto most = [&](int begin, int end) {
    return *std::max_element(there.back.begin() + begin, there.back.begin() + end);
  };
  const auto laid =
      std::find_if(there.back.begin(), there.back.end(), [&](std::size_t b) { return b > state; });
  const int moves = int(laid - there.back.begin()) + 1;
  ASSERT_LT(moves, 20);
  EXPECT_LT(there.back[std::size_t(moves) - 1], state + state / 100) << "bytes: a blade is laid on the skin";
  EXPECT_LT(most(moves, 40), state / 100) << "bytes a frame: the blade moves, and has gone";
  EXPECT_LT(most(24, int(there.back.size())), state / 8) << "bytes a frame of eight parts: the hook pulls";
}

}  // namespace
}  // namespace turgor
