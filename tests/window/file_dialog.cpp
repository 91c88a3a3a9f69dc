#include "turgor/window/file_dialog.hpp"

#include <array>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

// Folders come first; other files and hidden entries are left out.
TEST(FileDialog, ListsFoldersAndScenes) {
  const fs::path folder = test::fresh_folder();
  fs::create_directories(folder / "z"), fs::create_directories(folder / ".hidden");
  for (const char* name : {"b.toml", "a.mrk.json", "a.nii", ".c.toml"}) std::ofstream(folder / name) << "";
  constexpr std::array<std::string_view, 2> kEndings{".toml", ".mrk.json"};
  const FolderList list = list_folder(folder, kEndings);
  ASSERT_EQ(list.entries.size(), 3u);
  EXPECT_EQ(list.entries[0].name, "z");
  EXPECT_TRUE(list.entries[0].is_folder);
  EXPECT_EQ(list.entries[1].name, "a.mrk.json");
  EXPECT_EQ(list.entries[2].name, "b.toml");
  EXPECT_EQ(list.problem, "");
  EXPECT_NE(list_folder(folder / "none", kEndings).problem, "");
}

// A typed folder is entered; a saved name gets its ending.
TEST(FileDialog, ConfirmsFilesAndEntersFolders) {
  const fs::path folder = test::fresh_folder();
  fs::create_directories(folder / "inner");
  FileDialog dialog;
  open_dialog(FileDialog::Purpose::kSave, folder, "inner", dialog);
  EXPECT_FALSE(confirm(dialog));
  EXPECT_TRUE(dialog.is_open);
  EXPECT_EQ(dialog.folder, folder / "inner");
  dialog.name = "new";
  EXPECT_EQ(confirm(dialog), folder / "inner" / "new.toml");
  EXPECT_FALSE(dialog.is_open);
  open_dialog(FileDialog::Purpose::kOpen, folder, "", dialog);
  EXPECT_FALSE(confirm(dialog)) << "no name yet";
}

}  // namespace
}  // namespace turgor
