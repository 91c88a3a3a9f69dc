// Scenes of blocks that are fixed, hang, lie on each other and slide.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/sim/world.hpp"

namespace turgor::test {

inline Scene organs_scene(const std::string& text) {
  Result<Scene> scene = parse_scene(text, "organs.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

inline World organs_world(const Exec& exec, const std::string& text) {
  Result<World> world = load_world(exec, organs_scene(text));
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// Steps a number of frames.
inline void advance(const Exec& exec, World& world, int frames) {
  for (int n = 0; n < frames; n++) ASSERT_TRUE(step(exec, world));
}

/// [body.NAME]: a block of soft tissue, not cached.
inline std::string block_text(const std::string& name, const std::string& corner, const std::string& size,
                              const std::string& count, const std::string& fixed, double young = 2e4) {
  return "[body." + name + "]\nmodel = \"sfem\"\nblock = { size = " + size + ", count = " + count +
         ", corner = " + corner + " }\nfixed = \"" + fixed + "\"\nyoung = " + std::to_string(young) +
         "\npoisson = 0.3\ncache = false\n";
}

/// Mean displacement of a body's vertices in the latest frame [m].
inline Vec3d mean_displacement(const SfemBody& body) {
  Vec3d sum;
  double mass = 0;
  for (std::size_t v = 0; v < body.flight->u.size(); v++)
    sum += body.flight->u[v] * body.model.mass[v], mass += body.model.mass[v];
  return sum / mass;
}
inline double mass_of(const SfemBody& body) {
  double mass = 0;
  for (const double m : body.model.mass) mass += m;
  return mass;
}

}  // namespace turgor::test
