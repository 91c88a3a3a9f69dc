#include "turgor/io/files/hdf5_check.hpp"

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/files/hdf5_file.hpp"

namespace turgor::io {
namespace {

namespace fs = std::filesystem;

/// A program in the position of turgor-read; TURGOR_READ names it while this lives.
class OtherReader {
 public:
  explicit OtherReader(const std::string& script) {
    const fs::path file = test::fresh_folder() / "turgor-read";
    test::write(file, "#!/bin/sh\n" + script + "\n");
    fs::permissions(file, fs::perms::owner_all);
    setenv("TURGOR_READ", file.c_str(), 1);
  }
  OtherReader(const OtherReader&) = delete;
  ~OtherReader() { unsetenv("TURGOR_READ"); }
};

// The check of a recording with many snapshots needs no memory for each of its datasets.
//
// It left datasets open that are not chunked, 4.7 KB each; recordings of 50 000 counted as damaged.
TEST(Hdf5Check, MemoryIsIndependentOfDatasetCount) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer keeps freed memory";
#endif
  const fs::path path = test::fresh_folder() / "long.h5";
  const std::vector<float> center = {1, 2, 3};
  Result<Hdf5File> file = Hdf5File::create(path);
  for (int n = 0; n < 20000; n++) ASSERT_TRUE(file->write<float>("/center/" + std::to_string(n), center, 3));
  ASSERT_TRUE(file->close());
  const Result<std::string> damage = find_hdf5_damage(path, {.memory = std::size_t{64} << 20});
  ASSERT_TRUE(damage) << damage.error().message;
  EXPECT_EQ(*damage, "");
}

// The times of a check grow with the file; its memory does not.
TEST(Hdf5Check, TimesGrowWithFile) {
  const ChildLimits small = hdf5_check_limits(0), large = hdf5_check_limits(std::uintmax_t{4} << 30);
  EXPECT_EQ(small.processor_seconds, 10);
  EXPECT_GT(large.processor_seconds, 600);
  EXPECT_GT(large.seconds, large.processor_seconds) << "the processor may be shared";
  EXPECT_EQ(large.memory, small.memory);
}

// A check that takes too long is no verdict on the file, and says why it was stopped.
TEST(Hdf5Check, LongCheckIsNoVerdict) {
  const OtherReader reader("while :; do :; done");
  EXPECT_REFUSED(find_hdf5_damage("some.h5", {.processor_seconds = 1}),
                 "some.h5: cannot be checked: it exceeded 1 s of processor time and was stopped");
  EXPECT_REFUSED(find_hdf5_damage("some.h5", {.seconds = 0.1}),
                 "some.h5: cannot be checked: it made no progress for 0.1 s and was stopped");
}

// A file for which memory runs out is damaged or too large; the message names both, and the limit.
TEST(Hdf5Check, MemoryIsNamed) {
  const fs::path cyclic = fs::path(TURGOR_SOURCE_DIR) / "tests/io/damaged/cyclic-heap.h5";
  const std::string expected =
      "damaged or cut short, or too large to be checked: it needs more than 0.268 GB of memory";
  const OtherReader reader("exit 254");
  EXPECT_EQ(find_hdf5_damage("some.h5", hdf5_check_limits(0)).value(), expected);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  unsetenv("TURGOR_READ");
  EXPECT_EQ(find_hdf5_damage(cyclic, hdf5_check_limits(0)).value(), expected);
#endif
}

}  // namespace
}  // namespace turgor::io
