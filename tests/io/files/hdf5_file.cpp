#include "turgor/io/files/hdf5_file.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <numeric>
#include <thread>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

// Arrays and texts are read back exactly; wrong counts and types are errors.
TEST(Hdf5File, ArraysAndTextsRoundTrip) {
  const std::string path = test::fresh_folder() / "arrays.h5";
  std::vector<float> many(30000);
  std::iota(many.begin(), many.end(), 0.5f);
  const std::vector<std::int32_t> few = {-1, 2, 3};
  {
    Result<Hdf5File> file = Hdf5File::create(path);
    ASSERT_TRUE(file);
    EXPECT_TRUE(file->write<float>("/deep/in/many", many, 3));
    EXPECT_TRUE(file->write<std::int32_t>("/few", few));
    EXPECT_TRUE(file->write<double>("/none", {}));
    EXPECT_TRUE(file->write_text("/text", "Ü = \"ü\""));
    EXPECT_TRUE(file->write_text("/empty", ""));
  }
  const Result<Hdf5File> file = Hdf5File::open(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->read<float>("/deep/in/many", 30000).value(), many);
  EXPECT_EQ(file->read<std::int32_t>("/few", 3).value(), few);
  EXPECT_TRUE(file->read<double>("/none", 0).value().empty());
  EXPECT_EQ(file->read_text("/text").value(), "Ü = \"ü\"");
  EXPECT_EQ(file->read_text("/empty").value(), "");
  EXPECT_EQ(file->read<std::int32_t>("/few", 4).error().message, path + ": /few: expected 4 values, found 3");
  EXPECT_EQ(file->read<float>("/few", 3).error().message,
            path + ": /few: the values have an unexpected type");
  EXPECT_EQ(file->read<float>("/gone", 3).error().message, path + ": /gone: is missing");
  EXPECT_EQ(file->count("/few", 2).error().message, path + ": /few: expected at most 2 values, found 3");
  EXPECT_EQ(file->read_text("/few").error().message, path + ": /few: expected a text, found something else");
}

// Datasets grow row by row, and groups have attributes.
TEST(Hdf5File, AppendsRowsAndAttributes) {
  const std::string path = test::fresh_folder() / "growing.h5";
  std::vector<std::int64_t> expected;
  {
    Result<Hdf5File> file = Hdf5File::create(path);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->make_group("/a/b"));
    for (std::int64_t n = 0; n < 50; n++) {
      const std::vector<std::int64_t> rows(std::size_t(3 * n), (n << 33) + 1);
      ASSERT_TRUE(file->append<std::int64_t>("/a/rows", rows, 3));
      expected.insert(expected.end(), rows.begin(), rows.end());
      ASSERT_TRUE(file->append<std::int64_t>("/a/numbers", {&n, 1}));
    }
    EXPECT_TRUE(file->write_ascii_attribute("/a", "Type", "Grid"));
    EXPECT_TRUE(
        file->write_attribute("/a/b", "Version", std::span<const std::int64_t>(expected.data() + 9, 2)));
    EXPECT_FALSE(file->append<std::int64_t>("/a/numbers", expected, 3)) << "it has one column";
    EXPECT_TRUE(file->close());
  }
  const Result<Hdf5File> file = Hdf5File::open(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->read<std::int64_t>("/a/rows", expected.size()).value(), expected);
  EXPECT_EQ(file->read<std::int64_t>("/a/numbers", 50).value()[49], 49);
  EXPECT_EQ(file->read_attribute("/a", "Type"), "Grid");
  EXPECT_EQ(file->read_numbers("/a/b", "Version"), (std::vector<std::int64_t>{expected[9], expected[10]}));
  EXPECT_TRUE(file->read_numbers("/a", "Type").empty()) << "a text";
}

// A file with a cyclic heap is rejected as damaged.
//
// Found by mutating a recording: HDF5 1.10 follows the cyclic free list of a heap forever and allocates
// without bound.
TEST(Hdf5File, RejectsCyclicHeap) {
  const auto file =
      Hdf5File::open(std::filesystem::path(TURGOR_SOURCE_DIR) / "tests/io/damaged/cyclic-heap.h5");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("cyclic-heap.h5: the HDF5 file is damaged or cut short"),
            std::string::npos)
      << file.error().message;
}

// Threads that read one file at the same time all read it, and none waits for another's check.
//
// The check was a fork: it took over HDF5's lock as it was, waited for it forever, and after 20 s the file
// counted as damaged.
TEST(Hdf5File, ThreadsReadOneFile) {
  const std::string path = test::fresh_folder() / "shared.h5";
  const std::vector<float> values(3 << 17, 1.5f);
  {
    Result<Hdf5File> file = Hdf5File::create(path);
    ASSERT_TRUE(file && file->write<float>("/values", values, 3));
  }
  std::atomic<int> read{0};
  std::vector<std::thread> threads;
  const auto begin = std::chrono::steady_clock::now();
  for (int t = 0; t < 6; t++)
    threads.emplace_back([&] {
      for (int n = 0; n < 25; n++) {
        const Result<Hdf5File> file = Hdf5File::open(path);
        read += file && file->read<float>("/values", values.size());
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(read, 6 * 25);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(18));
}

// Without turgor-read a file is not opened, and the message says what is missing.
TEST(Hdf5File, MissingReaderIsNamed) {
  const std::string path = test::fresh_folder() / "some.h5";
  ASSERT_TRUE(Hdf5File::create(path)->write_text("/text", "some"));
  setenv("TURGOR_READ", "/no/such/turgor-read", 1);
  const Result<Hdf5File> file = Hdf5File::open(path);
  unsetenv("TURGOR_READ");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message, path +
                                      ": cannot be checked: TURGOR_READ: expected the path of the program "
                                      "turgor-read, found \"/no/such/turgor-read\"");
  EXPECT_TRUE(Hdf5File::open(path));
}

}  // namespace
}  // namespace turgor
