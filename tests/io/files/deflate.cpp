#include "turgor/io/files/deflate.hpp"

#include <random>
#include <string>
#include <vector>

#include "tests/folders.hpp"

namespace turgor::io {
namespace {

std::string gzipped(const Exec& exec, std::string_view head, std::string_view bytes) {
  std::string packed;
  deflate_gzip(exec, {head, bytes}, [&packed](std::string_view piece) { packed += piece; });
  return packed;
}

/// Bytes of which about half can be left out.
std::string similar_bytes(std::size_t count) {
  std::mt19937 random(3);
  std::string bytes(count, 'a');
  for (char& byte : bytes) byte = char('a' + random() % 16);
  return bytes;
}

// A stream that is compressed in pieces inflates to the same bytes with the right checksum, whatever its
// length; two threads write the same stream as one.
TEST(Deflate, PiecesInflateToSameBytes) {
  const std::filesystem::path folder = test::fresh_folder();
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, kPiece, kPiece + 1, 2 * kPiece + 12345}) {
    const std::string head = "head", bytes = similar_bytes(count), packed = gzipped(Exec(1), head, bytes);
    EXPECT_EQ(packed, gzipped(Exec(2), head, bytes));
    test::write(folder / "packed.gz", packed);
    std::vector<std::byte> out(head.size() + count);
    const Inflated inflated = inflate({folder / "packed.gz", 0, std::int64_t(packed.size())}, 0, out);
    EXPECT_EQ(inflated.end, Inflated::End::kExact) << count;
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(out.data()), out.size()), head + bytes);
    EXPECT_LT(packed.size(), 0.7 * double(count) + 64);
  }
}

}  // namespace
}  // namespace turgor::io
