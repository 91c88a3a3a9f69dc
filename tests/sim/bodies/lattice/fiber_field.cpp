// Fibers of cells from a file of directions, read by a scene.
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/live/requests.hpp"

namespace turgor {
namespace {

const Exec kFieldExec(1);

/// The block of fat on bone without its cut, and directions of fibers on the grid of its CT: oblique on one
/// side, none on the other.
class FiberField : public ::testing::Test {
 protected:
  std::filesystem::path folder = test::fresh_folder();
  static constexpr Vec3 kOblique{0.6f, 0, 0.8f};

  void SetUp() override {
    const CtVolume ct = test::block_ct();
    ASSERT_TRUE(write_ct(folder / "block.nii", ct));
    VectorVolume field{ct.grid, std::vector<Vec3>(ct.samples.size())};
    for (int k = 0; k < ct.grid.size.z; k++)
      for (int j = 0; j < ct.grid.size.y; j++)
        for (int i = 0; i < 20; i++) field.at(i, j, k) = kOblique;
    ASSERT_TRUE(write_displacement(folder / "fibers.nrrd", field));
    field.grid.origin = {10, 10, 10};
    ASSERT_TRUE(write_displacement(folder / "far.nrrd", field));
  }
  Result<Scene> read(const std::string& fiber) const {
    return parse_scene(
        "[world]\n[body.block]\nmodel = \"lattice\"\nct = \"block.nii\"\nblock = 2\nfixed = \"bone\"\n"
        "tissue = { law = \"exponential\", fat = 3e3, fiber = " +
            fiber + " }\n",
        folder / "block.toml");
  }
  /// Number of cells with this direction.
  static int count(const World& world, Vec3 line) {
    const lattice::Anatomy& anatomy = world.lattice_bodies[0].model.anatomy;
    const lattice::CellLaws& laws = anatomy.cell_laws;
    int found = 0;
    for (std::size_t slot = 0; slot < laws.fiber.size(); slot++)
      found += anatomy.cell_young[slot] > 0 &&
               norm(Vec3{laws.fiber_x[slot], laws.fiber_y[slot], laws.fiber_z[slot]} - line) < 1e-6f;
    return found;
  }
};

// Cells have the direction of the file where it has one, and that of the scene elsewhere. A law that changes
// while the world runs keeps them.
TEST_F(FiberField, CellsHaveDirectionsOfFile) {
  const Result<Scene> made =
      read("{ stiffness = 1e3, direction = [0, 1, 0], direction_field = \"fibers.nrrd\" }");
  ASSERT_TRUE(made) << made.error().message;
  auto scene = std::make_shared<const Scene>(*made);
  World world = test::block_world(kFieldExec, *scene);
  const int oblique = count(world, kOblique), other = count(world, {0, 1, 0});
  EXPECT_GT(oblique, 100);
  EXPECT_GT(other, 100);
  ASSERT_TRUE(
      apply_request(kFieldExec, ChangeRequest{"body.block.tissue.fiber.stiffness", "2e3"}, scene, world));
  EXPECT_EQ(world.lattice_bodies[0].model.params.tissue.fiber.stiffness, 2e3);
  EXPECT_EQ(count(world, kOblique), oblique);
  ASSERT_TRUE(apply_request(kFieldExec, ChangeRequest{"body.block.tissue.fiber.direction", "[0, 0, 1]"},
                            scene, world));
  EXPECT_EQ(count(world, kOblique), oblique);
  EXPECT_EQ(count(world, {0, 0, 1}), other);
}

// A file of another patient, a missing file and a body without fibers are errors.
TEST_F(FiberField, WrongFilesAreRefused) {
  const auto error = [&](const std::string& fiber) {
    const Result<Scene> scene = read(fiber);
    if (!scene) return scene.error().message;
    const Result<World> world = load_world(kFieldExec, *scene);
    return world ? std::string("none") : world.error().message;
  };
  EXPECT_NE(error("{ stiffness = 1e3, direction_field = \"far.nrrd\" }").find("is it the same patient?"),
            std::string::npos);
  EXPECT_NE(error("{ stiffness = 1e3, direction_field = \"missing.nrrd\" }").find("missing.nrrd"),
            std::string::npos);
  EXPECT_NE(error("{ direction_field = \"fibers.nrrd\" }").find("needs fibers"), std::string::npos);
}

}  // namespace
}  // namespace turgor
