#include "tests/app/program.hpp"

namespace turgor {
namespace {

// Without a display the command ends with a message that names `turgor run`.
TEST(ViewCommand, MissingDisplayEndsWithMessage) {
  const std::string scene = TURGOR_SOURCE_DIR "/scenes/palpation.toml";
  const test::Ended ended =
      test::run_program("view " + scene, test::fresh_folder(), "unset DISPLAY WAYLAND_DISPLAY");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("turgor run " + scene), std::string::npos) << ended.printed;
  EXPECT_EQ(std::count(ended.printed.begin(), ended.printed.end(), '\n'), 1) << ended.printed;
}

// A scene that does not exist is named, with or without a display, together with the nearest name.
TEST(ViewCommand, MissingSceneIsNamed) {
  const test::Ended ended =
      test::run_program("view " TURGOR_SOURCE_DIR "/scenes/palpaton.toml", test::fresh_folder());
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("palpaton.toml: does not exist; did you mean palpation.toml?"),
            std::string::npos)
      << ended.printed;
  EXPECT_EQ(std::count(ended.printed.begin(), ended.printed.end(), '\n'), 1) << ended.printed;
}

// Without a scene the command opens the gallery, which needs a display too.
TEST(ViewCommand, GalleryNeedsDisplay) {
  const test::Ended ended = test::run_program("view", test::fresh_folder(), "unset DISPLAY WAYLAND_DISPLAY");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("no window: "), std::string::npos) << ended.printed;
  EXPECT_NE(ended.printed.find("turgor run SCENE"), std::string::npos) << ended.printed;
}

}  // namespace
}  // namespace turgor
