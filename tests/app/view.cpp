#include "tests/app/program.hpp"

namespace turgor {
namespace {

TEST(View, without_a_display_it_ends_with_a_sentence_that_names_turgor_run) {
  const std::string scene = TURGOR_SOURCE_DIR "/scenes/palpation.toml";
  const test::Ended ended =
      test::run_program("view " + scene, test::fresh_folder(), "unset DISPLAY WAYLAND_DISPLAY");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("turgor run " + scene), std::string::npos) << ended.printed;
  EXPECT_EQ(std::count(ended.printed.begin(), ended.printed.end(), '\n'), 1) << ended.printed;
}

TEST(View, it_needs_a_scene) {
  const test::Ended ended = test::run_program("view", test::fresh_folder());
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("scene is required"), std::string::npos) << ended.printed;
}

}  // namespace
}  // namespace turgor
