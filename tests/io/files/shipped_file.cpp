#include "turgor/io/files/shipped_file.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

// A file of the system is preferred to the package's.
TEST(ShippedFile, PrefersFileOfSystem) {
  const fs::path file = test::fresh_folder() / "font.ttf";
  test::write(file, "font");
  EXPECT_EQ(shipped_file("font.ttf", {"/no/such/font.ttf", file}), file);
  EXPECT_EQ(shipped_file("no-such-file-anywhere", {}), "");
}

// TURGOR_SHARE names the folder of a package whose program is another, as a Python module's.
TEST(ShippedFile, IsFoundInFolderOfVariable) {
  const fs::path folder = test::fresh_folder();
  test::write(folder / "font.ttf", "font");
  setenv("TURGOR_SHARE", folder.c_str(), 1);
  EXPECT_EQ(shipped_file("font.ttf", {"/no/such/font.ttf"}), folder / "font.ttf");
  EXPECT_EQ(shipped_file("other.ttf", {}), "");
  unsetenv("TURGOR_SHARE");
}

// In an unpacked package, files are found relative to the program, wherever the folder is.
TEST(ShippedFile, IsFoundRelativeToProgram) {
  const fs::path folder = test::fresh_folder();
  fs::create_directories(folder / "bin"), fs::create_directories(folder / "share/turgor");
  test::write(folder / "bin/turgor", "program"), test::write(folder / "share/turgor/font.ttf", "font");
  EXPECT_EQ(io::file_shipped_with(folder / "bin/turgor", "font.ttf"), folder / "share/turgor/font.ttf");
  EXPECT_EQ(io::file_shipped_with(folder / "bin/turgor", "other.ttf"), "");
}

}  // namespace
}  // namespace turgor
