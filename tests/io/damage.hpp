// Corruption of valid files, for tests of readers.
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace turgor::test {

/// One replacement in a valid file, and the expected error message.
struct Damage {
  std::string text, from, to, message;
};

inline std::string damaged(const Damage& damage) {
  std::string text = damage.text;
  const std::size_t at = text.find(damage.from);
  EXPECT_NE(at, text.npos) << damage.from;
  return at == text.npos ? text : text.replace(at, damage.from.size(), damage.to);
}

}  // namespace turgor::test
