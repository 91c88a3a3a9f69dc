// A small test world: fat on a slab of bone, with skin and a cut across the front.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/folders.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor::test {

/// Voxels of 4 mm: air around fat, and a deeper tissue from the voxel `deep_from` on.
struct LayeredBlock {
  Int3 size{40, 24, 40}, air{4, 4, 4};   // voxels; air on every side
  Vec3d origin{-0.078, -0.036, -0.078};  // [m]
  int deep_from = 14;
  float deep = 1000;  // [HU]
};
inline CtVolume layered_ct(const LayeredBlock& block) {
  CtVolume ct;
  ct.grid.size = block.size;
  ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = block.origin;
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  const Int3 end = block.size - block.air;
  for (int k = block.air.z; k < end.z; k++)
    for (int j = block.air.y; j < end.y; j++)
      for (int i = block.air.x; i < end.x; i++) ct.at(i, j, k) = j < block.deep_from ? -100 : block.deep;
  return ct;
}

/// 40 mm of fat on a slab of bone; the front is at y = −20 mm.
inline CtVolume block_ct() { return layered_ct({}); }

inline std::string block_scene_text(const std::string& ct) {
  return "[world]\nduration = 0.2\nframe_rate = 50\n"
         "[body.block]\nmodel = \"lattice\"\nct = \"" +
         ct +
         "\"\nblock = 2\nfixed = \"bone\"\n"
         "[incision.cut]\nbody = \"block\"\nfrom = [0.002, -0.02, -0.03]\nto = [0.002, -0.02, 0.03]\ndepth = "
         "0.012\n"
         "start = 0.05\nduration = 0.05\n[output]\nsnapshots = { every = 0.1 }\n";
}

/// Writes block.nii, and labels.nii with label_of(i, j, k) for each of its voxels.
template <class LabelOf>
void write_labeled_block(const std::filesystem::path& folder, const LabelOf& label_of) {
  const CtVolume ct = block_ct();
  LabelVolume labels;
  labels.grid = ct.grid, labels.samples.assign(ct.samples.size(), 0);
  for (int k = 0; k < ct.grid.size.z; k++)
    for (int j = 0; j < ct.grid.size.y; j++)
      for (int i = 0; i < ct.grid.size.x; i++) labels.at(i, j, k) = std::uint16_t(label_of(i, j, k));
  ASSERT_TRUE(write_ct(folder / "block.nii", ct));
  ASSERT_TRUE(write_labels(folder / "labels.nii", labels));
}

/// The scene, with its CT written into the same folder.
inline Scene block_scene(const std::filesystem::path& folder,
                         const std::vector<std::string>& overrides = {}) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  Result<Scene> scene = parse_scene(block_scene_text("block.nii"), folder / "block.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

inline World block_world(const Exec& exec, const Scene& scene) {
  Result<World> world = load_world(exec, scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

}  // namespace turgor::test
