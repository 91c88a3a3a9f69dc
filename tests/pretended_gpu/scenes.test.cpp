// Whole scenes on a pretended GPU against the same scenes on the host.
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
  std::vector<std::size_t> downloaded;  // downloaded bytes of each frame
};
Retracted retract(const std::string& device) {
  const Exec exec(2);
  const Scene scene = read_scene(TURGOR_SOURCE_DIR "/scenes/retract.toml",
                                 {"world.device=" + device, "body.torso.block=4",
                                  "body.torso.solver.ordering=colors", "world.duration=1.1"})
                          .value();
  Retracted run{.world = load_world(exec, scene).value(), .measures = {}, .downloaded = {}};
  run.measures = make_measures(run.world);
  for (int n = 0; n < frame_count(scene); n++) {
    const std::size_t before = pretended_counts().downloaded;
    const FrameReport frame = step(exec, run.world).value();
    EXPECT_TRUE(frame.finite);
    measure_frame(exec, run.world, frame, false, run.measures);
    run.downloaded.push_back(pretended_counts().downloaded - before);
  }
  return run;
}

// A hook retracts a wound lip on the GPU as on the host, and each frame downloads few nodes.
TEST(PretendedGpuScenes, RetractionMatchesHost) {
  const Retracted host = retract("cpu"), device = retract("gpu");
  const CutMeasures &host_wound = host.measures.cuts.at(0), &device_wound = device.measures.cuts.at(0);
  EXPECT_GT(host_wound.wound.gape_max, 2e-3) << "m";
  EXPECT_NEAR(device_wound.wound.gape_max, host_wound.wound.gape_max, 1e-3 * host_wound.wound.gape_max);
  EXPECT_NEAR(device_wound.wound.edge_displacement, host_wound.wound.edge_displacement,
              1e-3 * host_wound.wound.edge_displacement);
  const TouchLog &host_samples = host.world.tools.at(0).samples,
                 &device_samples = device.world.tools.at(0).samples;
  ASSERT_EQ(host_samples.size(), device_samples.size());
  double largest = 0, difference = 0;
  for (std::size_t n = 0; n < host_samples.size(); n++) {
    largest = std::max(largest, norm(host_samples[n].force));
    difference = std::max(difference, norm(host_samples[n].force - device_samples[n].force));
  }
  EXPECT_GT(largest, 0.2) << "N";
  EXPECT_LT(difference, 0.01 * largest) << "N";

  const std::size_t state =
      9 * sizeof(Real) * host.world.lattice_bodies.at(0).model.anatomy.inverse_mass.size();
  const auto most = [&](int begin, int end) {
    return *std::max_element(device.downloaded.begin() + begin, device.downloaded.begin() + end);
  };
  const auto path_computed = std::find_if(device.downloaded.begin(), device.downloaded.end(),
                                          [&](std::size_t b) { return b > state; });
  const int moves = int(path_computed - device.downloaded.begin()) + 1;
  ASSERT_LT(moves, 20);
  EXPECT_LT(device.downloaded[std::size_t(moves) - 1], state + state / 100)
      << "bytes: the blade path is computed on the skin";
  EXPECT_LT(most(moves, 40), state / 100) << "bytes per frame: during and after the cut";
  EXPECT_LT(most(24, int(device.downloaded.size())), state / 8)
      << "bytes per frame, an eighth of the state: the hook pulls";
}

}  // namespace
}  // namespace turgor
