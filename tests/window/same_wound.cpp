// The picture of a wound in the window, compared with the picture that a run of the same scene draws.
#include "tests/window/window_test.hpp"
#include "turgor/pictures/picture_items.hpp"
#include "turgor/view/mesh_view.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

/// The snapshot of a run after some frames.
WorldSnapshot run_to(const fs::path& scene, int frame) {
  const Exec exec(1);
  World world = block_world(exec, read_scene(scene).value());
  while (world.frame < frame) EXPECT_TRUE(step(exec, world));
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  return snapshot;
}

// A paused wound has the vertices of a run at the same frame, and at rest the window shows the run's picture.
TEST_F(WindowTest, WoundLooksAsInRun) {
  const fs::path scene = folder_ / "block.toml";
  ASSERT_TRUE(write_ct(folder_ / "block.nii", block_ct()));
  std::ofstream(scene) << block_scene_text("block.nii");
  open(scene);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.frame > 12; }));
  type("space");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.plays; }));
  type("1");
  draw_for(1.5);  // at rest: full quality
  // vertices
  const WorldSnapshot& shown = now().snapshot;
  const WorldSnapshot expected = run_to(scene, shown.frame);
  EXPECT_GT(expected.bodies[0].triangles.size(), expected.bodies[0].wall_begin + 30) << "the cut is open";
  EXPECT_EQ(shown.bodies[0].triangles, expected.bodies[0].triangles);
  EXPECT_EQ(shown.bodies[0].x, expected.bodies[0].x);
  // pixels
  type("p");
  const Image window = read_picture(folder_ / "out" / "block-1.png");
  ASSERT_EQ(window.width, kWidth) << window_->viewer().message;
  const Area area = window_->viewer().area;
  const Camera camera = window_->viewer().camera;
  window_.reset();  // its context would be current
  PictureItems items;
  add_world(expected, SkinColor::kNone, nullptr, camera.eye, items, {}, 0);
  const int left = int(area.x), top = int(std::lround(area.y)), width = int(area.width),
            height = int(std::lround(area.height));
  const Result<Image> run = draw_meshes(items.items, camera, width, height);
  ASSERT_TRUE(run) << run.error().message;
  constexpr int kCube = 110;  // pixels at the upper right
  int compared = 0, different = 0;
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      if (y < kCube && x > width - kCube) continue;
      compared++;
      different += difference(window.at(left + x, top + y), run->at(x, y)) > 6;
    }
  EXPECT_GT(compared, 200'000);
  EXPECT_LT(different, 0.001 * compared);
}

}  // namespace
}  // namespace turgor
