#include "turgor/core/hash.hpp"

#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

using HashOf = std::uint64_t (*)(const void*, std::size_t, std::uint64_t);
class EitherHash : public testing::TestWithParam<HashOf> {
 protected:
  std::uint64_t hash(const void* data, std::size_t size) const { return GetParam()(data, size, kHashSeed); }
};
INSTANTIATE_TEST_SUITE_P(OfBytes, EitherHash, testing::Values(hash_bytes, hash_long_bytes));

// Flipping any single bit of the input changes the hash.
TEST_P(EitherHash, EveryBitChangesHash) {
  std::vector<unsigned char> bytes(111);
  for (std::size_t n = 0; n < bytes.size(); n++) bytes[n] = static_cast<unsigned char>(n * 7);
  std::set<std::uint64_t> seen{hash(bytes.data(), bytes.size())};
  for (std::size_t n = 0; n < bytes.size(); n++)
    for (int bit = 0; bit < 8; bit++) {
      bytes[n] ^= static_cast<unsigned char>(1 << bit);
      EXPECT_TRUE(seen.insert(hash(bytes.data(), bytes.size())).second) << "byte " << n << ", bit " << bit;
      bytes[n] ^= static_cast<unsigned char>(1 << bit);
    }
}

// Swapping two words of the input changes the hash.
TEST_P(EitherHash, OrderChangesHash) {
  std::vector<std::uint64_t> words(13);
  for (std::size_t n = 0; n < words.size(); n++) words[n] = n;
  const std::uint64_t before = hash(words.data(), 8 * words.size());
  for (std::size_t n = 0; n + 1 < words.size(); n++)
    for (std::size_t m = n + 1; m < words.size(); m++) {
      std::swap(words[n], words[m]);
      EXPECT_NE(hash(words.data(), 8 * words.size()), before) << n << ", " << m;
      std::swap(words[n], words[m]);
    }
}

// Inputs of zeros that differ only in length have different hashes.
TEST_P(EitherHash, LengthChangesHash) {
  const char zeros[80] = {};
  EXPECT_NE(hash(zeros, 8), hash(zeros, 16));
  EXPECT_NE(hash(zeros, 3), hash(zeros, 4));
  EXPECT_NE(hash(zeros, 32), hash(zeros, 64));
}

// The text of a hash has sixteen hexadecimal digits, leading zeros included.
TEST(Hash, TextHasSixteenDigits) { EXPECT_EQ(hash_text(0x0123456789abcdefull), "0123456789abcdef"); }

}  // namespace
}  // namespace turgor
