// Tools whose shape is a mesh, on a body of elements.
#include <algorithm>

#include <fmt/format.h>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {
namespace {

// A tool from a mesh presses as deep wherever the mesh lies on its z axis.
TEST(MeshTool, PressDoesNotDependOnOriginOfMesh) {
  const auto folder = test::fresh_folder();
  std::vector<World> worlds;
  for (const double low : {0.0, 0.02, -0.03}) {
    std::string cube;
    for (int v = 0; v < 8; v++)
      cube += fmt::format("v {} {} {}\n", v & 1 ? 0.005 : -0.005, v & 2 ? 0.005 : -0.005,
                          low + (v & 4 ? 0.01 : 0));
    for (const char* face : {"1 3 4", "1 4 2", "5 6 8", "5 8 7", "1 2 6", "1 6 5", "3 7 8", "3 8 4", "1 5 7",
                             "1 7 3", "2 4 8", "2 8 6"})
      cube += fmt::format("f {}\n", face);
    ASSERT_TRUE(write_file(folder / "cube.obj", cube));
    Result<Scene> scene = parse_scene(
        "[world]\nduration = 0.3\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count "
        "= [8, 8, 4] }\nfixed = \"bottom\"\nyoung = 5e3\npoisson = 0.4\ncache = false\npatch.radius = "
        "0.02\n[tool.cube]\nbody = "
        "\"pad\"\nshape = { mesh = \"cube.obj\" }\npress = { at_fraction = [0.5, 0.5, 1], depth = 0.003, "
        "start = 0, duration = 0.1, hold = 0.05 }\n",
        folder / "pad.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    worlds.push_back(test::sfem_world(Exec(1), *scene));
    for (int frame = 0; frame < frame_count(*scene); frame++) ASSERT_TRUE(step(Exec(1), worlds.back()));
  }
  double most = 0;
  for (const ForceSample& s : worlds[0].tools[0].samples) most = std::max(most, norm(s.force));
  EXPECT_GT(most, 0.1) << "N";
  for (const World& world : worlds)
    for (std::size_t i = 0; i < worlds[0].tools[0].samples.size(); i++)
      EXPECT_LT(norm(world.tools[0].samples[i].force - worlds[0].tools[0].samples[i].force), 0.01 * most)
          << i;
}

}  // namespace
}  // namespace turgor
