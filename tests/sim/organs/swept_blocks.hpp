// Free and fixed blocks of lattice tissue that lie on each other, and what bears them.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "organs_scene.hpp"

namespace turgor::test {

constexpr double kBlockYoung = 5e3;  // [Pa]

constexpr double kBlockGravity = 9.81;  // [m/s²]

struct SweptBlock {
  std::string name;
  double front = 0;  // [m]
  bool on_bone = false;
  Vec3d middle = {};  // y is unused [m]
  int height = 8;     // voxels
};

/// A block of voxels of 4 mm in air, 64 mm wide along x and z. Its faces are at x = ±32 mm, z = ±32 mm from
/// the middle, and from y = `front` on. Below it is bone, if requested.
inline CtVolume block_ct(const SweptBlock& block) {
  const int end = 4 + block.height;
  CtVolume ct;
  ct.grid.size = {24, end + 8, 24};
  ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = {block.middle.x - 0.046, block.front - 0.014, block.middle.z - 0.046};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  for (int k = 4; k < 20; k++)
    for (int j = 4; j < (block.on_bone ? end + 4 : end); j++)
      for (int i = 4; i < 20; i++) ct.at(i, j, k) = j < end ? -100 : 1000;
  return ct;
}

/// [body.NAME]: such a block with the file NAME.nii, Poisson's ratio 0 and hardly any skin. Its modulus is
/// kBlockYoung unless the keys have a `tissue.young`.
inline std::string lattice_text(const std::string& name, const std::string& fixed,
                                const std::string& keys = "") {
  const bool has_young = keys.find("tissue.young") != std::string::npos;
  return fmt::format(
      "[body.{}]\nmodel = \"lattice\"\nct = \"{}.nii\"\nblock = 2\nfixed = \"{}\"\n{}"
      "tissue.poisson = 0\nskin.tension = 0\nskin.stiffness = 1e-3\nskin.shear = 0\nsolver.damping = "
      "0\nsolver.sweeps = 20\n{}",
      name, name, fixed, has_young ? "" : fmt::format("tissue.young = {}\n", kBlockYoung), keys);
}
inline std::string world_text(const std::string& gravity) {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n";
}
inline std::string contact_text(const std::string& a, const std::string& b, double friction,
                                const std::string& keys = "") {
  return fmt::format("[contact.{}-{}]\nbetween = [\"{}\", \"{}\"]\nfriction = {}\n{}", a, b, a, b, friction,
                     keys);
}

inline World blocks_world(const Exec& exec, const std::vector<SweptBlock>& blocks, const std::string& text) {
  const std::filesystem::path folder = fresh_folder();
  for (const SweptBlock& block : blocks)
    EXPECT_TRUE(write_ct(folder / (block.name + ".nii"), block_ct(block)));
  const Result<Scene> scene = parse_scene(text, folder / "blocks.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

inline Vec3d contact_force(const World& world, std::size_t contact = 0) {
  return world.coupling.contacts[contact].samples.back().force;
}

/// Momentum, mass and mean displacement of a lattice.
struct Whole {
  double mass = 0;
  Vec3d momentum, displacement;
};
inline Whole whole_of(const LatticeBody& body) {
  Whole whole;
  for (std::size_t slot = 0; slot < body.model.anatomy.inverse_mass.size(); slot++)
    if (const double w = double(body.model.anatomy.inverse_mass[slot]); w > 0) {
      whole.mass += 1 / w;
      whole.momentum += Vec3d(body.state->motion.v[slot]) / w;
      whole.displacement += Vec3d(body.state->motion.u[slot]) / w;
    }
  whole.displacement = whole.displacement / whole.mass;
  return whole;
}

inline const LatticeBody& body_named(const World& world, const std::string& name) {
  for (const LatticeBody& body : world.lattice_bodies)
    if (body.name == name) return body;
  return world.lattice_bodies.at(0);
}
inline Whole whole_of(const World& world, const std::string& name) {
  return whole_of(body_named(world, name));
}
inline Vec3d load_on(const World& world, const std::string& name) {
  return total_force(body_named(world, name).cloth);
}

}  // namespace turgor::test
