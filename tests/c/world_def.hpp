// Definitions of worlds for tests of the C interface.
#pragma once

#include <gtest/gtest.h>
#include <turgor.h>

namespace turgor::test {

/// Defaults with the text of a scene, which must outlive the definition.
inline tg_world_def def_of(const char* text, int threads = 2) {
  tg_world_def def;
  EXPECT_EQ(tg_default_world_def(&def, sizeof def), TG_OK);
  def.text = text, def.threads = threads;
  return def;
}

}  // namespace turgor::test
