// A world of the C interface that ends with its scope, and a pad with a finger.
#pragma once

#include <cstdint>
#include <string>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/world_def.hpp"

namespace turgor::test {

inline const std::string kPadText = pad_scene(R"([tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.04], [0.2, 0.03, 0.03, 0.032]]
)");
inline const char* const kPad = kPadText.c_str();

struct OwnedWorld {
  tg_world* world = nullptr;
  explicit OwnedWorld(const tg_world_def& def) {
    EXPECT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error();
  }
  explicit OwnedWorld(const char* text) : OwnedWorld(def_of(text)) {}
  ~OwnedWorld() { EXPECT_EQ(tg_world_destroy(world), TG_OK) << tg_error(); }
  OwnedWorld(const OwnedWorld&) = delete;
  OwnedWorld& operator=(const OwnedWorld&) = delete;
};

inline std::uint64_t hash_of(tg_world* world) {
  std::uint64_t hash = 0;
  EXPECT_EQ(tg_world_state_hash(world, &hash), TG_OK) << tg_error();
  return hash;
}

/// Command that moves the finger above the middle of the pad to a height [m].
inline tg_command finger_at(double z) { return {{0.03, 0.03, z}, {1, 0, 0, 0}, 0, 0}; }

}  // namespace turgor::test
