#include "turgor/core/hash.hpp"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Flipping any single bit of the input changes the hash.
TEST(Hash, EveryBitChangesHash) {
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

// Inputs of zeros that differ only in length have different hashes.
TEST(Hash, LengthChangesHash) {
  const char zeros[24] = {};
  EXPECT_NE(hash_bytes(zeros, 8), hash_bytes(zeros, 16));
  EXPECT_NE(hash_bytes(zeros, 3), hash_bytes(zeros, 4));
}

// The text of a hash has sixteen hexadecimal digits, leading zeros included.
TEST(Hash, TextHasSixteenDigits) { EXPECT_EQ(hash_text(0x0123456789abcdefull), "0123456789abcdef"); }

}  // namespace
}  // namespace turgor
