// Files of worlds that are read into a world that ran on meanwhile: everything is as it was at saving.
#include "turgor/sim/autosave/saved_world.hpp"

#include <gtest/gtest.h>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/live/by_hand.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

const Exec kSavingThread(1);

/// A world with its scene, and what its files need.
struct Saving {
  std::shared_ptr<const Scene> scene;
  World world;
  Measures measures;
  LoadedWorld loaded;
  std::filesystem::path file;

  Saving(Scene given, std::filesystem::path path)
      : scene(std::make_shared<const Scene>(std::move(given))), file(std::move(path)) {
    Result<World> made = load_world(kSavingThread, *scene);
    EXPECT_TRUE(made) << made.error().message;
    world = std::move(*made), measures = make_measures(world), loaded = loaded_world(world);
  }
  void run(int frames) {
    for (int frame = 0; frame < frames; frame++) {
      const Result<FrameReport> done = step(kSavingThread, world);
      ASSERT_TRUE(done) << done.error().message;
    }
  }
  void save() {
    const Status saved = save_world(file, *scene, world, measures, loaded);
    ASSERT_TRUE(saved) << saved.error().message;
  }
  void read() {
    const Status done = read_saved_world(kSavingThread, file, *scene, loaded, world, measures);
    ASSERT_TRUE(done) << done.error().message;
  }
  std::uint64_t hash() const { return state_hash(world); }
};

// The log of forces is that of the file: as long, and with times that ascend.
TEST(SavedWorld, ReplacesLogOfForces) {
  const auto folder = test::fresh_folder();
  Saving saving(test::body_scene(folder), folder / "state");
  saving.run(3), saving.save();
  const TouchLog& log = saving.world.tools[0].samples;
  const std::size_t samples = log.size();
  const std::uint64_t saved = saving.hash();
  saving.run(3), saving.read();
  EXPECT_EQ(log.size(), samples);
  EXPECT_EQ(saving.hash(), saved);
  saving.run(1);
  for (std::size_t n = 1; n < log.size(); n++) EXPECT_GT(log[n].time, log[n - 1].time);
}

// A file refers to the patch of the loaded world. It can be read after that patch has been replaced.
TEST(SavedWorld, ReadsAfterPatchWasReplaced) {
  for (const std::string memory : {"4", "0.004"}) {  // all Green's functions, or columns on demand
    const auto folder = test::fresh_folder();
    const Scene scene =
        test::body_scene(folder, "patch = { radius = 0.008 }\n", {"body.pad.memory=" + memory});
    Saving ran(scene, folder / "state"), fresh(scene, folder / "state");
    ASSERT_EQ(fresh.world.sfem_bodies[0].facts.on_demand, memory != "4");
    ran.save();
    const std::uint64_t begin = ran.hash();
    ran.run(15);
    EXPECT_GE(ran.world.sfem_bodies[0].rebuilds.size(), 2u);
    const std::size_t samples = ran.world.tools[0].samples.size();
    ran.read();
    EXPECT_EQ(ran.hash(), begin);
    EXPECT_EQ(ran.world.tools[0].samples.size(), 0u);
    ran.run(15), fresh.run(15);
    EXPECT_EQ(ran.hash(), fresh.hash());
    EXPECT_EQ(ran.world.tools[0].samples.size(), samples);
    // a file of the middle of the slide
    ran.save(), fresh.run(4);
    const std::uint64_t end = fresh.hash();
    fresh.read(), fresh.run(4);
    EXPECT_EQ(fresh.hash(), end);
  }
}

// A nonlinear patch continues from its displacement, in a world that has just been loaded and in one that ran
// on.
TEST(SavedWorld, ContinuesNonlinearPatch) {
  const auto folder = test::fresh_folder();
  const Scene scene = test::body_scene(folder,
                                       "patch = { radius = 0.013, refinement = 2 }\n"
                                       "law = \"exponential\"\nstiffening = 4\n",
                                       {"tool.finger.press.depth=0.004"});
  Saving ran(scene, folder / "state"), fresh(scene, folder / "state");
  ran.run(5), ran.save(), ran.run(5);
  const std::uint64_t end = ran.hash();
  EXPECT_GT(ran.world.sfem_bodies[0].law_summary.solutions, 5);
  for (Saving* one : {&ran, &fresh}) {
    one->read(), one->run(5);
    EXPECT_EQ(one->hash(), end);
  }
}

// A file that refers to a patch which the loaded world lacks is damaged.
TEST(SavedWorld, RefusesMissingPatch) {
  const auto folder = test::fresh_folder();
  Saving saving(test::body_scene(folder), folder / "state");
  saving.save(), saving.run(1);
  const std::uint64_t before = saving.hash();
  saving.loaded.patches.patches[0] = nullptr;
  const Status done = read_saved_world(kSavingThread, saving.file, *saving.scene, saving.loaded, saving.world,
                                       saving.measures);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("is damaged"), std::string::npos) << done.error().message;
  EXPECT_EQ(saving.hash(), before);
}

// Reading keeps the arrays of bodies in their memory, which views of a program refer to.
TEST(SavedWorld, ReadingKeepsMemory) {
  const auto folder = test::fresh_folder();
  Saving saving(test::four_kinds_scene(folder), folder / "state");
  const auto addresses = [&] {
    const World& world = saving.world;
    const lattice::State& block = world.lattice_bodies[0].state.host();
    const cloth::State& sheet = world.cloth_bodies[0].state.host();
    return std::vector<const void*>{block.motion.u.x.data(),
                                    block.motion.v.z.data(),
                                    world.lattice_bodies[0].ct.samples.data(),
                                    sheet.x.x.data(),
                                    world.cloth_bodies[0].model.original.data(),
                                    world.sfem_bodies[0].model.body.mesh.vertices.data(),
                                    world.rhombus_bodies[0].model.surface.vertices.data(),
                                    &world.sfem_bodies[0]};
  };
  const std::vector<const void*> before = addresses();
  saving.run(2), saving.save();
  const std::uint64_t saved = saving.hash();
  const float height = saving.world.cloth_bodies[0].state.host().x.z[5];
  saving.run(6);  // through a cut
  EXPECT_NE(saving.world.cloth_bodies[0].state.host().x.z[5], height);
  saving.read();
  EXPECT_EQ(addresses(), before);
  EXPECT_EQ(saving.world.cloth_bodies[0].state.host().x.z[5], height);
  EXPECT_EQ(saving.hash(), saved);
}

// The surface of a loaded world is that of the cut in its file, also if the cut before had as many edges.
TEST(SavedWorld, ReplacesCutOfEqualSize) {
  const auto folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder, {"incision.cut=", "world.duration=1"});
  Saving cut(scene, folder / "state"), other(scene, folder / "state");
  const auto cut_at = [](Saving& saving, double x) {
    const CutByHand line{.body = {BodyKind::kLattice, 0},
                         .name = {},
                         .points = {{x, -0.02, -0.03}, {x, -0.02, 0.03}},
                         .depth = 0.012,
                         .duration = 0};
    const Result<std::string> name = cut_by_hand(kSavingThread, line, saving.scene, saving.world);
    EXPECT_TRUE(name) << name.error().message;
    saving.run(2);
  };
  const auto surface_of = [](const Saving& saving) {
    const LatticeBody& body = saving.world.lattice_bodies[0];
    return lattice::build_surface(body.model, body.state.cuts(), &body.ct);
  };
  cut_at(cut, 0.002), cut_at(other, 0.010);  // a cell further
  EXPECT_EQ(cut_version(cut.world.lattice_bodies[0].state.cuts()),
            cut_version(other.world.lattice_bodies[0].state.cuts()));
  EXPECT_NE(cuts_hash(cut.world), cuts_hash(other.world));
  cut.save(), other.read();
  EXPECT_EQ(cuts_hash(cut.world), cuts_hash(other.world));
  EXPECT_EQ(cut.hash(), other.hash());
  const lattice::BodySurface saved = surface_of(cut), read = surface_of(other);
  EXPECT_EQ(saved.triangles, read.triangles);
  EXPECT_EQ(saved.rest, read.rest);
}

// A tool continues on the path or the hand motion that a program gave it.
TEST(SavedWorld, KeepsPathsOfTools) {
  const auto folder = test::fresh_folder();
  const Scene scene = test::body_scene(folder);
  Saving driven(scene, folder / "state"), fresh(scene, folder / "state");
  const auto row = [](double time, double x, double z) {
    return PathRow{.time = time, .position = {x, 0.03, z}};
  };
  driven.run(2);
  TouchingTool& tool = driven.world.tools[0];
  tool.path = {{row(0, 0.03, 0.04), row(0.3, 0.03, 0.0345)}, false};
  driven.save(), driven.run(10), fresh.read(), fresh.run(10);
  EXPECT_EQ(driven.hash(), fresh.hash());
  EXPECT_FALSE(fresh.world.tools[0].path.smooth);
  for (const double x : {0.025, 0.035}) {
    tool.hand = {{0, {.pose = {{0.03, 0.03, 0.0345}, {}}}}, {0.4, {.pose = {{x, 0.03, 0.0345}, {}}}}};
    driven.save(), driven.run(3), fresh.read(), fresh.run(3);
    EXPECT_EQ(driven.hash(), fresh.hash());
    EXPECT_EQ(fresh.world.tools[0].hand.size(), 2u);
  }
  tool.hand.clear();
  driven.save(), driven.run(3), fresh.read(), fresh.run(3);
  EXPECT_EQ(driven.hash(), fresh.hash());
}

}  // namespace
}  // namespace turgor
