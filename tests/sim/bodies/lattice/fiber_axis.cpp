// Fibers along the long axis of a label: the body is stiffer along it.
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/models/lattice/solver/energy.hpp"
#include "turgor/sim/live/requests.hpp"

namespace turgor {
namespace {

const Exec kFiberExec(2);

/// The block with fibers. Label 5 is a bar along z in its middle.
class FiberAxis : public ::testing::Test {
 protected:
  std::filesystem::path folder = test::fresh_folder();

  void SetUp() override {
    test::write_labeled_block(folder, [](int i, int j, int k) {
      return k >= 6 && k < 34 && j >= 4 && j < 14 && i >= 14 && i < 26 ? 5 : 0;
    });
  }
  World fibered(const std::string& keys) const {
    const Result<Scene> scene = fibered_scene(keys);
    EXPECT_TRUE(scene) << scene.error().message;
    return test::block_world(kFiberExec, *scene);
  }
  Result<Scene> fibered_scene(const std::string& keys) const {
    return parse_scene(
        "[world]\nduration = 0.1\n[body.block]\nmodel = \"lattice\"\nct = \"block.nii\"\nlabels = "
        "\"labels.nii\"\nblock = 2\nfixed = \"bone\"\nskin = false\n" +
            keys,
        folder / "block.toml", {});
  }
};

/// Energy of a body stretched by 0.1 along an axis [J].
double stretched(const World& world, Vec3d axis) {
  const lattice::Model& model = world.lattice_bodies[0].model;
  lattice::State state = lattice::make_state(model);
  const Int3 size = model.anatomy.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d x = hadamard(Vec3d(Int3{i, j, k}), Vec3d(model.anatomy.lattice.spacing));
        const auto slot = std::size_t(node_slot(model.anatomy.lattice, {i, j, k}));
        state.motion.u.set(slot, Vec3(axis * (0.1 * dot(axis, x))));
      }
  return lattice::energy(kFiberExec, model, state);
}
constexpr Vec3d kAcross{1, 0, 0}, kAlong{0, 0, 1};

// Fibers of a layer by label lie along its long axis, here z, also after its stiffness changed in the
// running world.
TEST_F(FiberAxis, StiffensAlongLabel) {
  const auto bar = [](const std::string& fiber) {
    return "tissue = { law = \"exponential\", fat = 3e3 }\n"
           "layers = [{ name = \"bar\", label = 5, young = 3e3, fiber = { stiffness = 2e4, " +
           fiber + " } }]\n";
  };
  World axis = fibered(bar("direction = [0, 0, 0]"));
  const World z = fibered(bar("direction = [0, 0, 1]"));
  EXPECT_NEAR(stretched(axis, kAlong), stretched(z, kAlong), 1e-5 * stretched(z, kAlong));
  EXPECT_NEAR(stretched(axis, kAcross), stretched(z, kAcross), 1e-5 * stretched(z, kAcross));
  const World across = fibered(bar("direction = [1, 0, 0]"));
  EXPECT_GT(stretched(axis, kAlong), 1.02 * stretched(across, kAlong));
  // a change in the running world
  auto scene = std::make_shared<const Scene>(*fibered_scene(bar("direction = [0, 0, 0]")));
  ASSERT_TRUE(
      apply_request(kFiberExec, ChangeRequest{"body.block.layers[0].fiber.stiffness", "4e4"}, scene, axis));
  const World stiffer = fibered(
      "tissue = { law = \"exponential\", fat = 3e3 }\nlayers = [{ name = \"bar\", label = 5, young = 3e3, "
      "fiber = { stiffness = 4e4, direction = [0, 0, 1] } }]\n");
  EXPECT_NEAR(stretched(axis, kAlong), stretched(stiffer, kAlong), 1e-5 * stretched(stiffer, kAlong));
}

// Without a label there is no axis.
TEST_F(FiberAxis, ZeroDirectionNeedsLabel) {
  const Result<Scene> by_depth = fibered_scene(
      "tissue = { law = \"exponential\" }\n"
      "layers = [{ name = \"a\", young = 3e3, fiber = { stiffness = 1e4, direction = [0, 0, 0] } }]\n");
  ASSERT_FALSE(by_depth);
  EXPECT_NE(by_depth.error().message.find("a layer with a label"), std::string::npos);
}

}  // namespace
}  // namespace turgor
