#include "turgor/window/film.hpp"

#include <chrono>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

// Without ffmpeg the pictures are kept in the folder that the message names.
TEST(Film, MissingFfmpegKeepsPictures) {
  const fs::path out = test::fresh_folder();
  const std::string path = std::getenv("PATH");
  WindowFilm film;
  add_to_film(make_image(8, 6), out, film);
  setenv("PATH", "", 1);
  const std::string said = end_film(out, "liver", film);
  setenv("PATH", path.c_str(), 1);
  EXPECT_NE(said.find("liver-frames-1"), std::string::npos) << said;
  EXPECT_TRUE(fs::exists(out / "liver-frames-1" / "000000.png"));
  EXPECT_FALSE(fs::exists(out / ".film-1"));
  EXPECT_TRUE(film.frames.empty());
}

// A video lasts as long as its recording: the picture before a pause stands for the frames of the pause.
TEST(Film, SlowPicturesKeepTime) {
  const fs::path out = test::fresh_folder();
  WindowFilm film;
  EXPECT_TRUE(is_due(film));
  add_to_film(make_image(8, 6), out, film);
  EXPECT_FALSE(is_due(film));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(is_due(film));
  add_to_film(make_image(8, 6), out, film);
  ASSERT_GE(film.frames.size(), 11u);
  for (std::size_t n = 0; n + 1 < film.frames.size(); n++) EXPECT_EQ(film.frames[n], film.frames[0]);
  EXPECT_NE(film.frames.back(), film.frames[0]);
}

// A picture that cannot be written leaves no folder.
TEST(Film, WriteErrorLeavesNoFolder) {
  const fs::path out = test::fresh_folder();
  WindowFilm film;
  EXPECT_NE(add_to_film(Image(), out, film).find("000000.png"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(out));
}

}  // namespace
}  // namespace turgor
