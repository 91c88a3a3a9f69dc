#include "turgor/io/hdf5_file.hpp"

#include <numeric>

#include <gtest/gtest.h>

#include "folders.hpp"

namespace turgor {
namespace {

TEST(Hdf5File, ArraysAndTextsComeBackAsTheyWere) {
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
            path + ": /few: the values are of another type than a recording's");
  EXPECT_EQ(file->read<float>("/gone", 3).error().message, path + ": /gone: is missing");
  EXPECT_EQ(file->count("/few", 2).error().message, path + ": /few: expected at most 2 values, found 3");
  EXPECT_EQ(file->read_text("/few").error().message, path + ": /few: expected a text, found something else");
}

// Found by mutating a recording: HDF5 1.10 goes round in the list of free space of a heap, for ever and with
// all the memory there is.
TEST(Hdf5File, AFileThatLeadsTheLibraryRoundInCirclesIsRefused) {
  const auto file =
      Hdf5File::open(std::filesystem::path(TURGOR_SOURCE_DIR) / "tests/io/damaged/cyclic-heap.h5");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("cyclic-heap.h5: the HDF5 file is damaged or cut short"),
            std::string::npos)
      << file.error().message;
}

}  // namespace
}  // namespace turgor
