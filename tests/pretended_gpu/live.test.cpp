// Changes of running scenes on a pretended GPU: requests, lists that no longer fit into its memory, and the
// transfers of a frame.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "turgor/core/gpu.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/world.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

const Exec kTwo(2);

/// The scene with a hook on the GPU, in large cells.
std::shared_ptr<const Scene> retract_scene(const std::vector<std::string>& more = {},
                                           const std::string& device = "gpu") {
  std::vector<std::string> overrides = {"world.device=" + device, "body.torso.block=6",
                                        "body.torso.solver.ordering=colors",
                                        "body.torso.tissue.partial_cells=false"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return std::make_shared<const Scene>(
      read_scene(TURGOR_SOURCE_DIR "/scenes/retract.toml", overrides).value());
}
std::shared_ptr<const Scene> flag_scene(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"world.device=gpu", "body.flag.solver.method=sweeps"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return std::make_shared<const Scene>(read_scene(TURGOR_SOURCE_DIR "/scenes/flag.toml", overrides).value());
}
void step_frames(World& world, int frames) {
  for (int n = 0; n < frames; n++) EXPECT_TRUE(step(kTwo, world).value().finite);
}
std::size_t bytes_of_state(const lattice::Model& model) {
  return 9 * sizeof(Real) * model.anatomy.inverse_mass.size();
}
Json report_of(const Scene& scene, const World& world) {
  return simulation_report(kTwo, scene, world, make_measures(world), {});
}

// A stitch on a body that steps on the GPU is refused, also while its values are on the host.
TEST(PretendedGpuLive, StitchIsRefused) {
  auto scene = retract_scene();
  World world = load_world(kTwo, *scene).value();
  step_frames(world, 24);
  ASSERT_EQ(world.cuts.at(0).done, 1);
  LatticeBody& body = world.lattice_bodies.at(0);
  const lattice::BladePath& path = *world.cuts[0].path;
  const std::size_t middle = path.points.size() / 2;
  const Grid& grid = body.model.anatomy.grid;
  StitchRequest stitch;
  for (const double side : {-0.01, 0.01})
    stitch.through.push_back(grid.origin + grid.axes * (path.points[middle] + across_at(path, middle) * side +
                                                        path.inward[middle] * 0.005));
  stitch.tension = 0.5;
  ASSERT_TRUE(apply_request(kTwo, ChangeRequest{"world.gravity", "[0, 0, -1]"}, scene, world));
  (void)body.state.host();
  ASSERT_TRUE(body.state.has_device());
  const Status laid = apply_request(kTwo, stitch, scene, world);
  ASSERT_FALSE(laid);
  EXPECT_EQ(laid.error().message, "no stitch: stitches need world.device = \"cpu\", found \"gpu\"");
  step_frames(world, 2);
}

// Keys of other bodies and tools leave a body on the GPU, and upload nothing.
TEST(PretendedGpuLive, FrictionLeavesBodyOnGpu) {
  auto scene = retract_scene({"incision.midline.start=2"});
  World world = load_world(kTwo, *scene).value();
  step_frames(world, 4);
  const lattice::DeviceState& state = world.lattice_bodies.at(0).state;
  for (const auto& [key, value] : {std::pair("tool.hook.friction", "0.7"),
                                   {"world.gravity", "[0, 0, -1]"},
                                   {"body.torso.solver.sweeps", "9"}}) {
    const PretendedCounts before = pretended_counts();
    ASSERT_TRUE(apply_request(kTwo, ChangeRequest{key, value}, scene, world));
    EXPECT_TRUE(state.is_on_device()) << key;
    step_frames(world, 1);
    const PretendedCounts now = pretended_counts();
    const std::size_t most = bytes_of_state(world.lattice_bodies[0].model) / 8;
    EXPECT_LT(now.uploaded - before.uploaded, most) << key;
    EXPECT_LT(now.downloaded - before.downloaded, most) << key;
  }
}

/// Gape after a cut under a tension that changes when it is complete [m].
double gape_of(const std::string& device, double tension, std::optional<double> later) {
  auto scene = retract_scene({fmt::format("body.torso.skin.tension={}", tension),
                              "incision.midline.duration=0", "tool.hook.grasp.start=2"},
                             device);
  World world = load_world(kTwo, *scene).value();
  Measures measures = make_measures(world);
  step_frames(world, 6);
  if (later) {
    EXPECT_TRUE(apply_request(kTwo, ChangeRequest{"body.torso.skin.tension", fmt::format("{}", *later)},
                              scene, world));
    EXPECT_EQ(world.lattice_bodies.at(0).state.is_on_device(), device == "gpu");
  }
  step_frames(world, 14);
  measure_frame(kTwo, world, FrameReport{}, false, measures);
  return measures.cuts.at(0).wound.gape_max;
}

// Another tension after a cut opens the wound on the GPU as on the host.
TEST(PretendedGpuLive, TensionAfterCutMatchesHost) {
  const double host = gape_of("cpu", 45, 90), device = gape_of("gpu", 45, 90), less = gape_of("cpu", 45, {});
  EXPECT_GT(host, 1.2 * less);
  EXPECT_NEAR(device, host, 1e-3 * host) << "m";
}

// A flag downloads what its hold and its pole read, not its state.
TEST(PretendedGpuLive, FlagDownloadsLittle) {
  const auto scene = flag_scene();
  World world = load_world(kTwo, *scene).value();
  step_frames(world, 2);
  const ClothBody& flag = world.cloth_bodies.at(0);
  const std::size_t state = 6 * sizeof(Real) * std::size_t(flag.model.count);
  for (int n = 0; n < 8; n++) {
    const std::size_t before = pretended_counts().downloaded;
    step_frames(world, 1);
    EXPECT_LT(pretended_counts().downloaded - before, state / 8) << "bytes, frame " << n;
  }
}

// Forces on hold and obstacles are those of a cloth whose whole state is read.
TEST(PretendedGpuLive, ClothHasForcesOfDownloadedCloth) {
  const Scene scene =
      parse_scene(
          "[world]\ndevice = \"gpu\"\ngravity = [0, 0, -9.81]\n[body.towel]\nmodel = \"cloth\"\n"
          "sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0.2, 0], columns = 10, rows = 10 }\n"
          "[body.towel.hold.edge]\nbox = [[-0.001, -1, -1], [0.001, 1, 1]]\n"
          "[body.towel.obstacle.table]\nplane = { through = [0, 0, -0.003], normal = [0.1, 0, 1] }\n",
          "towel.toml")
          .value();
  World world = load_world(kTwo, scene).value(), downloaded = load_world(kTwo, scene).value();
  ClothBody &towel = world.cloth_bodies.at(0), &other = downloaded.cloth_bodies.at(0);
  (void)other.state.watch();  // every step downloads the state
  step_frames(world, 5), step_frames(downloaded, 5);
  EXPECT_TRUE(towel.state.is_on_device());
  EXPECT_FALSE(other.state.is_on_device());
  EXPECT_EQ(towel.obstacles.at(0).force.size(), 5u);
  EXPECT_GT(norm(towel.obstacles[0].force.back()), 0.01) << "N";
  EXPECT_EQ(towel.obstacles[0].force, other.obstacles.at(0).force);
  EXPECT_GT(norm(towel.holds.at(0).force.back()), 0.01) << "N";
  EXPECT_EQ(towel.holds[0].force, other.holds.at(0).force);
}

/// No device memory is free during its lifetime.
struct NoFreeMemory {
  std::size_t free = open_gpu().value().free_bytes;
  NoFreeMemory() { pretend_memory(0); }
  NoFreeMemory(const NoFreeMemory&) = delete;
  NoFreeMemory& operator=(const NoFreeMemory&) = delete;
  ~NoFreeMemory() { pretend_memory(free); }
};

// A cloth whose contacts no longer fit continues on the host, and so does a body whose cut does not. A note
// and the report say so.
TEST(PretendedGpuLive, LackOfMemoryIsNoted) {
  const auto flag = flag_scene(), torso = retract_scene({"incision.midline.duration=0"});
  World cloth = load_world(kTwo, *flag).value(), lattice = load_world(kTwo, *torso).value();
  step_frames(lattice, 2);
  EXPECT_EQ(report_of(*torso, lattice)["bodies"][0]["device"], "gpu");
  {
    const NoFreeMemory lack;
    step_frames(cloth, 2);
  }
  {
    const NoFreeMemory lack;
    step_frames(lattice, 4);
  }
  EXPECT_FALSE(cloth.cloth_bodies.at(0).state.has_device());
  EXPECT_FALSE(lattice.lattice_bodies.at(0).state.has_device());
  EXPECT_EQ(cloth.cloth_bodies[0].notes.back(),
            "steps on the host since 0 s: the GPU lacks memory for contacts, cuts or its solver");
  EXPECT_NE(lattice.lattice_bodies[0].notes.back().find("steps on the host since 0.0"), std::string::npos);
  EXPECT_EQ(report_of(*flag, cloth)["bodies"][0]["device"], "cpu");
  EXPECT_EQ(report_of(*torso, lattice)["bodies"][0]["device"], "cpu");
}

// A body whose changed model does not fit beside that of a copy of the world is reported on the host.
TEST(PretendedGpuLive, ReportNamesDeviceAfterChange) {
  const std::pair<std::shared_ptr<const Scene>, const char*> bodies[] = {{retract_scene(), "torso"},
                                                                         {flag_scene(), "flag"}};
  for (auto [scene, name] : bodies) {
    World world = load_world(kTwo, *scene).value();
    const World copy = copy_of(world);
    EXPECT_EQ(report_of(*scene, world)["bodies"][0]["device"], "gpu");
    const NoFreeMemory lack;
    ASSERT_TRUE(
        apply_request(kTwo, ChangeRequest{fmt::format("body.{}.stiffness_scale", name), "2"}, scene, world));
    EXPECT_EQ(report_of(*scene, world)["bodies"][0]["device"], "cpu") << name;
    EXPECT_EQ(report_of(*scene, copy)["bodies"][0]["device"], "gpu") << name;
  }
}

}  // namespace
}  // namespace turgor
