// Whole scenes on a pretended GPU against the same scenes on the host.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

/// A cut, and a hook that pulls one lip up. Without the coarse correction, which a GPU has without tools
/// only.
struct Retracted {
  World world;
  Measures measures;
  std::vector<std::size_t> downloaded;  // downloaded bytes of each frame
};
Retracted retract(const std::string& device) {
  const Exec exec(2);
  const Scene scene = read_scene(TURGOR_SOURCE_DIR "/scenes/retract.toml",
                                 {"world.device=" + device, "body.torso.block=4",
                                  "body.torso.solver.ordering=colors", "world.duration=1.1",
                                  "body.torso.tissue.partial_cells=false", "body.torso.solver.coarse=false"})
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

/// Positions after ten frames of gravity, whose body becomes `factor` times as stiff after five.
lattice::VecField stiffened(const std::string& device, double factor) {
  const Exec exec(2);
  const Scene scene =
      read_scene(TURGOR_SOURCE_DIR "/scenes/retract.toml",
                 {"world.device=" + device, "body.torso.block=6", "body.torso.solver.ordering=colors",
                  "body.torso.gravity=true", "body.torso.tissue.partial_cells=true"})
          .value();
  World world = load_world(exec, scene).value();
  for (int n = 0; n < 10; n++) {
    if (n == 5) {
      const Scene stiff = with_change(scene, "body.torso.stiffness_scale", fmt::format("{}", factor)).value();
      change_world(exec, scene, stiff, world);
    }
    EXPECT_TRUE(step(exec, world)->finite);
    EXPECT_EQ(world.lattice_bodies.at(0).state.is_on_device(), device == "gpu");
  }
  return world.lattice_bodies.at(0).state.host().motion.u;
}

double largest_difference(const lattice::VecField& a, const lattice::VecField& b) {
  double most = 0;
  for (int n = 0; n < int(a.x.size()); n++) most = std::max(most, double(norm(a[n] - b[n])));
  return most;
}

// A body on the GPU takes another stiffness while it runs, as on the host.
TEST(PretendedGpuScenes, LiveStiffnessMatchesHost) {
  const lattice::VecField host = stiffened("cpu", 4), device = stiffened("gpu", 4),
                          soft = stiffened("cpu", 1);
  const double effect = largest_difference(host, soft);
  EXPECT_GT(effect, 1e-5) << "m";
  EXPECT_LT(largest_difference(host, device), 0.01 * effect) << "m";
}

/// A flag after ten frames of wind, which becomes `factor` times as stiff after five.
std::vector<Vec3> stiffened_flag(const std::string& device, double factor) {
  const Exec exec(2);
  const Scene scene = read_scene(TURGOR_SOURCE_DIR "/scenes/flag.toml",
                                 {"world.device=" + device, "body.flag.solver.method=sweeps"})
                          .value();
  World world = load_world(exec, scene).value();
  for (int n = 0; n < 10; n++) {
    if (n == 5) {
      const Scene stiff = with_change(scene, "body.flag.stiffness_scale", fmt::format("{}", factor)).value();
      change_world(exec, scene, stiff, world);
    }
    EXPECT_TRUE(step(exec, world)->finite);
  }
  const cloth::State& state = world.cloth_bodies.at(0).state.host();
  std::vector<Vec3> positions;
  for (std::size_t v = 0; v < state.x.size(); v++) positions.push_back(state.x[v]);
  return positions;
}

// A cloth on the GPU does so, too.
TEST(PretendedGpuScenes, LiveClothStiffnessMatchesHost) {
  const std::vector<Vec3> host = stiffened_flag("cpu", 0.1), device = stiffened_flag("gpu", 0.1),
                          stiff = stiffened_flag("cpu", 1);
  double effect = 0, difference = 0;
  for (std::size_t v = 0; v < host.size(); v++) {
    effect = std::max(effect, double(norm(host[v] - stiff[v])));
    difference = std::max(difference, double(norm(host[v] - device[v])));
  }
  EXPECT_GT(effect, 1e-5) << "m";
  EXPECT_LT(difference, 0.1 * effect) << "m";
}

}  // namespace
}  // namespace turgor
