#include "turgor/core/hash.hpp"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(hash, a_change_of_any_bit_changes_it) {
  std::vector<unsigned char> bytes(37);
  for (std::size_t n = 0; n < bytes.size(); n++) bytes[n] = static_cast<unsigned char>(n * 7);
  std::set<std::uint64_t> seen{hash_bytes(bytes.data(), bytes.size())};
  for (std::size_t n = 0; n < bytes.size(); n++)
    for (int bit = 0; bit < 8; bit++) {
      bytes[n] ^= static_cast<unsigned char>(1 << bit);
      EXPECT_TRUE(seen.insert(hash_bytes(bytes.data(), bytes.size())).second)
          << "byte " << n << ", bit " << bit;
      bytes[n] ^= static_cast<unsigned char>(1 << bit);
    }
}

TEST(hash, lengths_count) {
  const char zeros[24] = {};
  EXPECT_NE(hash_bytes(zeros, 8), hash_bytes(zeros, 16));
  EXPECT_NE(hash_bytes(zeros, 3), hash_bytes(zeros, 4));
}

TEST(hash, text_is_sixteen_digits) { EXPECT_EQ(hash_text(0x0123456789abcdefull), "0123456789abcdef"); }

}  // namespace
}  // namespace turgor
