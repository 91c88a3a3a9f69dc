#include "turgor/window/settings.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

// Written settings are read back, in a folder that did not exist.
TEST(Settings, WrittenSettingsAreReadBack) {
  const fs::path file = test::fresh_folder() / "new" / "window.json";
  Settings settings;
  settings.width = 1600, settings.height = 1000;
  settings.appearance = {Theme::kLight, 21};
  settings.panels.controls = false, settings.panels.ct = true, settings.panels.side_width = 411;
  add_recent("/scenes/a.toml", settings), add_recent("/scenes/b.toml", settings);
  ASSERT_TRUE(write_settings(file, settings));
  const Result<Settings> read = read_settings(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, 1600);
  EXPECT_EQ(read->height, 1000);
  EXPECT_EQ(read->appearance, settings.appearance);
  EXPECT_FALSE(read->panels.controls);
  EXPECT_TRUE(read->panels.ct);
  EXPECT_EQ(read->panels.side_width, 411);
  EXPECT_EQ(read->recent, (std::vector<fs::path>{"/scenes/b.toml", "/scenes/a.toml"}));
}

// A missing file gives the defaults; other text is an error that names the file.
TEST(Settings, MissingFileIsDefaultDamagedIsError) {
  const fs::path folder = test::fresh_folder();
  const Result<Settings> none = read_settings(folder / "none.json");
  ASSERT_TRUE(none);
  EXPECT_EQ(none->width, 1280);
  EXPECT_EQ(none->height, 800);
  std::ofstream(folder / "bad.json") << "{ width";
  const Result<Settings> bad = read_settings(folder / "bad.json");
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("bad.json"), std::string::npos);
}

// Values out of range and of another type leave the defaults.
TEST(Settings, InvalidValuesLeaveDefaults) {
  const fs::path file = test::fresh_folder() / "odd.json";
  std::ofstream(file) << R"({"width": -5, "height": "tall", "text_size": 900, "theme": 3,
                             "recent": ["/a.toml", 7], "curves": "no", "side_width": null})";
  const Result<Settings> read = read_settings(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, 1280);
  EXPECT_EQ(read->height, 800);
  EXPECT_EQ(read->appearance, Appearance());
  EXPECT_EQ(read->recent.size(), 1u);
  EXPECT_TRUE(read->panels.curves);
}

// The latest scene comes first, once, and the list is limited.
TEST(Settings, RecentScenesAreUniqueAndLimited) {
  Settings settings;
  for (int n = 0; n < 15; n++) add_recent("/scenes/" + std::to_string(n) + ".toml", settings);
  add_recent("/scenes/8.toml", settings);
  ASSERT_EQ(settings.recent.size(), Settings::kMostRecent);
  EXPECT_EQ(settings.recent[0], "/scenes/8.toml");
  EXPECT_EQ(settings.recent[1], "/scenes/14.toml");
  EXPECT_EQ(std::count(settings.recent.begin(), settings.recent.end(), "/scenes/8.toml"), 1);
}

// The file is below the user's configuration folder.
TEST(Settings, FileIsInConfigurationFolder) {
  const char* had = std::getenv("XDG_CONFIG_HOME");
  const std::string before = had ? had : "";
  setenv("XDG_CONFIG_HOME", "/config", 1);
  EXPECT_EQ(settings_file(), "/config/turgor/window.json");
  if (had)
    setenv("XDG_CONFIG_HOME", before.c_str(), 1);
  else
    unsetenv("XDG_CONFIG_HOME");
}

}  // namespace
}  // namespace turgor
