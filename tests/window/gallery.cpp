#include "turgor/window/gallery.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "turgor/io/files/image.hpp"

namespace turgor {
namespace {

// Every scene of the program has a title, a sentence and a picture.
TEST(Gallery, ScenesHaveTitleSentenceAndPicture) {
  const std::vector<GalleryScene> scenes = list_scenes(scene_folder());
  EXPECT_GT(scenes.size(), 10u);
  EXPECT_TRUE(std::is_sorted(scenes.begin(), scenes.end(),
                             [](const GalleryScene& a, const GalleryScene& b) { return a.title < b.title; }));
  for (const GalleryScene& scene : scenes) {
    EXPECT_FALSE(scene.sentence.empty()) << scene.file;
    const Result<Image> picture = read_png(scene.picture);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 400) << scene.file;
    EXPECT_EQ(picture->height, 240) << scene.file;
  }
}

// Titles come from file names, sentences from the first comment, without commands and marks of code.
TEST(Gallery, TitlesAndSentences) {
  EXPECT_EQ(title_of("sheet-on-liver"), "Sheet on liver");
  EXPECT_EQ(first_comment("# A liver.\n# It is `soft`.\n# Your own: turgor run a.toml\n[world]\n"),
            "A liver. It is soft.");
  for (const GalleryScene& scene : list_scenes(scene_folder())) {
    EXPECT_EQ(scene.sentence.find('`'), std::string::npos) << scene.file;
    EXPECT_EQ(scene.sentence.find("turgor run"), std::string::npos) << scene.file;
  }
  EXPECT_EQ(first_comment("[world]\n# no\n"), "");
}

}  // namespace
}  // namespace turgor
